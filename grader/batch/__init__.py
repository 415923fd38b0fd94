"""The instructor's desk: from a class of submissions to marks, pages and files for Moodle.

In the order of the flow:

records           what passes between the modules
csv_table         CSV files of unknown dialect; cells that no spreadsheet obeys
moodle_archive    Moodle's archive, taken apart safely
discovery         what a folder holds: one candidate for each submission
contents          what of a candidate can be judged, and what is told of the rest
tasks             from a candidate to a task
dependencies      what its result depends on: grading, or its words alone
names             when two names may be one person's
roll              the persons of the class, by name, number and folder
identity          whom a submission is from: claims, and those that are torn
roster            one line for each person
moodle_dates      dates as Moodle writes them
moodle_worksheet  the grading worksheet, as it was downloaded
lateness          the course's deadline, a person's own, and Moodle's
manual_marks      manual.csv: rubric, comments, overrides
preparation       all that is known, and wrong, before the first submission is graded
grade_one         one submission, graded: a pure function, wherever it runs
gallery           the pictures of a submission for the class page
pool_worker       a process that grades many, one after the other
pool              local workers; a dead one is replaced
cluster           the same on a Dask cluster
results_folder    OUT: its lock, its class, what is known of each submission
progress          what the terminal shows meanwhile
marks             from points to a mark: scale, weights, bonus, lateness
grades_csv        grades.csv
last_run          what a run leaves for the next one; what has changed since, and why
student_pages     each person's page, under their own name
moodle_files      the worksheet filled in a copy, and the archive of feedback files
statistics        what the class page tells
class_page        index.html
outputs           everything that is given back
command           `batch DIR --out DIR`
purge             `purge DIR`

What is known of Moodle's importers stands in MOODLE.md.
"""
