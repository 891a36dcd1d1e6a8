"""Statistics, figures and pages of what Palpate measured.

Every module reads tables that the program wrote; none needs the engine's library.
"""
