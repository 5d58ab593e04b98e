"""Damper force estimation in real time, and the reasons why an estimate is wrong."""

__version__ = "0.1.0"
