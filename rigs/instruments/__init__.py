"""Instruments: channels, what a measuring chain does to a signal, the clock at which it is logged."""
