"""The engine: one for the process, computes whatever the pages want.

engine (what a page sees) <- crew (threads) <- schedule (what comes next) <- job (how work is cut),
and a module for each kind of work.
"""
