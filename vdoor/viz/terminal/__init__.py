"""A recorded run in a terminal: its stages as maps, plots and tables, and a stepper with key control."""
