"""The paper's own evidence, done again: its figures, its table and its claims, ours beside the printed.

What is computed: `walkthrough` (a run with what each stage found counted, figure 5), `figures` (3 and 4), `search`
(section III), `door_counts` (Table I), `errata` (where the paper cannot be taken by the letter). `claims` gathers it
all and checks what must hold.

What is shown: `tables` (as text), `pictures` on a `pictures_canvas`, `runs` (each to be recorded), and `report`, which
writes the folder of `vdoor paper --out`.
"""
