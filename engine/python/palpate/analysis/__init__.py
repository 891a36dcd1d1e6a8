"""Analysis in Python: tables, statistics, figures and pages."""
