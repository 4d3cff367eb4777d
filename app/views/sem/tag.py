"""Text of TIFF tag 34118, in which ZEISS microscopes keep the imaging parameters.

Lines end with CRLF, text is cp1252. A line in capitals names a parameter, the next says it. Before them stand numbers
without names; the fourth line is the side of a pixel in an image of 1024 columns [m], which some readers take.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from app.views.sem.units import clock, date, magnification, metric

if TYPE_CHECKING:
    from datetime import datetime

    from app.views.sem.view import View
    from rigs.machines.microscope import Microscope

TAG: Final = 34118
COLUMNS: Final = 1024


def lines_of(
    view: View, microscope: Microscope, *, tilt: float, rotation: float, moment: datetime, name: str
) -> dict[str, str]:
    """Return the parameters of an image and the lines that say them.

    Parameters
    ----------
    view : View
        Magnification and pixels.
    microscope : Microscope
        Its numbers.
    tilt, rotation : float
        Of the stage [deg].
    moment : datetime
        When the image was taken.
    name : str
        Name of its file.
    """
    return {
        "AP_MAG": f"Mag = {magnification(view.magnification)}",
        "AP_ACTUALKV": f"EHT = {microscope.voltage.value / 1e3:.2f} kV",
        "AP_WD": f"WD = {1e3 * microscope.working_distance.value:.1f} mm",
        "AP_WIDTH": f"Width = {metric(view.width * view.pixel, 4)}",
        "AP_HEIGHT": f"Height = {metric(view.height * view.pixel, 4)}",
        "AP_IMAGE_PIXEL_SIZE": f"Image Pixel Size = {metric(view.pixel, 4)}",
        "DP_IMAGE_STORE": f"Store resolution = {view.width} * {view.height}",
        "DP_DETECTOR_CHANNEL": f"Signal A = {microscope.signal}",
        "AP_STAGE_AT_T": f"Stage at T = {tilt:.1f} °",
        "AP_STAGE_AT_R": f"Stage at R = {rotation:.1f} °",
        "AP_DATE": f"Date :{date(moment)}",
        "AP_TIME": f"Time :{clock(moment)}",
        "SV_SERIAL_NUMBER": f"Serial No. = {microscope.serial}",
        "SV_FILE_NAME": f"File Name = {name}",
    }


def encoded(lines: dict[str, str], view: View) -> bytes:
    """Return the value of the tag."""
    unnamed = ["", "0", "0", f"{view.pixel * view.width / COLUMNS:.6e}"]
    named = [text for pair in lines.items() for text in pair]
    return ("\r\n".join([*unnamed, *named]) + "\r\n").encode("cp1252", errors="replace")
