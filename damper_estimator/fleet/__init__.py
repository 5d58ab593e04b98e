"""Many recordings on a cluster: the tasks, the workers, and the results.

The work on one recording and damper is passed in as a function (`Work`); this package knows which tasks exist, which
are done already, where results are stored, and how they become one dataset and one page.
"""
