"""make new: the files to touch for a new exercise, check, mistake or scene, with stubs in them.

    edits     what goes where in a file; all of it is written, or nothing
    exercise  an exercise with one function
    check     a check of a function, on one suite, or of a picture
    mistake   a known mistake
    scene     a scene of which pictures are expected

Every stub has a line with `MARK`, which says what to put there; a test holds that none is left.
"""
