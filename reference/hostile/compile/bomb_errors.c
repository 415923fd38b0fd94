/* Errors by the million. */
#define E oops oops2;
#define F E E E E E E E E E E
#define G F F F F F F F F F F
#define H G G G G G G G G G G
H H H H H H H H H H
