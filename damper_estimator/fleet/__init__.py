"""Many recordings on a cluster: what to do, who does it, what is kept.

What is done with one recording and damper is handed in as a function (`Work`); the room itself knows which tasks
there are, which are done already, where results lie, and how they become one dataset and one page.
"""
