"""Evidence of accuracy and cost: the benchmark of the methods and of other programs, maps of where
methods fail, and the tables and figures of the paper, computed. Only the commands `benchmark`,
`stability` and `reproduce`, and scripts, import it."""
