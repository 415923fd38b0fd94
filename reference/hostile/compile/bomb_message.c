#error "\033[2J\033]0;title\007 a terminal believes what it is told"
