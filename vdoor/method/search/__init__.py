"""Section III: the choice of doors as a problem, what a choice costs, the optimisers, and a bound on the optimum."""
