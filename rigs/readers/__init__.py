"""Readers of files that instruments wrote: ours, and those of real ones.

source     bytes and sheets as lines of fields
numbers    numbers as a country writes them
headings   what a heading means, and its unit
table      the table of a file: headings, units, columns
mapping    what a file does not say by itself
layouts    files without headings, by the dialects of our logs
measured   the table as measurements along axes
"""
