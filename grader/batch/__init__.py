"""The instructor's desk: from a class of submissions to marks, pages and files for Moodle.

records     what passes between the modules
unpacking   a Moodle archive, taken apart safely
finding     what a folder holds: one candidate for each submission
members     who made what; who is doubled
reading     from a candidate to a task
bundle      one submission, graded: a pure function, wherever it runs
gallery     the pictures of a submission for the class page
worker      a process that grades many, one after the other
crew        local workers; a dead one is replaced
cluster     the same on a Dask cluster
desk        OUT: its lock, what is known of each submission, what must be graded
manual      manual.csv: rubric, comments, overrides
marks       from points to a mark: scale, weights, bonus, lateness
sheets      CSV files of unknown dialect; cells that no spreadsheet obeys
moodle      the grading worksheet, filled in place, and the archive of feedback files
grades      grades.csv, and what changed since the last run
statistics  what the class page tells
classpage   index.html
progress    what the terminal shows meanwhile
outputs     everything that is given back
command     `batch DIR --out DIR`
purge       `purge DIR`
"""
