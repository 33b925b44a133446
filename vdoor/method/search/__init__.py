"""Section III: the choice of doors as an optimisation problem, its costs, optimisers, and a bound on the optimum."""
