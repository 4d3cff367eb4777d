"""Machines and what they hold a specimen by: data of machines, fixtures, wires, load trains, the rig put together."""
