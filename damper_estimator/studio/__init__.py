"""The workflow in the browser: compare, diagnose, add, fit, improve and save by eye and hand.

A view on the other rooms, with no analysis of its own. The page is Dash; its state is in the server, one session per
page; long works run in processes of their own.
"""
