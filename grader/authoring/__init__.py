"""Generators and benchmarks for those who maintain the workbook; never in a student's archive."""
