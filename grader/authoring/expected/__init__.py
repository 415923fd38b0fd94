"""make expected: the inputs that functions are judged on, the reference's answers, and pictures.

    command       all of it, or one thing by its name; or whether it has drifted
    one           one suite, picture or mistake again
    suites        how suites are made (vectors/), and the file that one becomes
    mistake_bank  what the checks find wrong in each known mistake
    manifest      what is said of each file of a folder
    pictures/     the pictures, and the limits by which they are judged

Every file is written whole; the index beside it says what it was made of.
"""
