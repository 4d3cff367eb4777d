"""From equilibrium to equilibrium: stiffness, linear solver, Newton, march."""
