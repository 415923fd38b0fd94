/* Parentheses, deep enough for the parser's stack. */
#define A ((((((((((
#define B A A A A A A A A A A
#define C B B B B B B B B B B
#define D C C C C C C C C C C
int deep = D D D D D D D D D D 1;
