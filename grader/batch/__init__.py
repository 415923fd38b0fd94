"""From a class of submissions to marks, pages and files for Moodle.

records          what passes between the modules
moodle_archive   a Moodle archive, taken apart safely
discovery        what a folder holds: one candidate for each submission
roster           who made what; who is doubled
tasks            from a candidate to a task
grade_one        one submission, graded: a pure function, wherever it runs
gallery          the pictures of a submission for the class page
pool_worker      a process that grades many, one after the other
pool             local workers; a dead one is replaced
cluster          the same on a Dask cluster
results_folder   OUT: its lock, what is known of each submission, what must be graded
manual_marks     manual.csv: rubric, comments, overrides
marks            from points to a mark: scale, weights, bonus, lateness
csv_table        CSV files of unknown dialect; cells that no spreadsheet obeys
moodle_worksheet the grading worksheet, filled in place, and the archive of feedback files
grades_csv       grades.csv, and what changed since the last run
statistics       what the class page tells
class_page       index.html
progress         what the terminal shows meanwhile
outputs          everything that is given back
command          `batch DIR --out DIR`
purge            `purge DIR`
"""
