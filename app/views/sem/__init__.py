"""Rendering of a run's frames as a scanning electron microscope shows them.

view      the stage's tilt and rotation, and the magnification at which a run fits into the image
blocks    load plates, substrate and gripper
raster    what the beam hits at every pixel, and how open the sky is above it
detector  from there to the grey levels of a secondary-electron image
bar       the data bar with its scale
tag       the text of ZEISS' TIFF tag
images    the TIFF files of a run
"""
