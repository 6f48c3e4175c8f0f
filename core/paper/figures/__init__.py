"""Pictures of results for print: what `rnnpb` draws without a browser.

One module for each figure of the paper; `style` has what they share.
"""
