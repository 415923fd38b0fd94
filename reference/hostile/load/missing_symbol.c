/* Takes the address of something that nobody defines: the loader refuses. */
extern int nobody_defines_this;
int *where = &nobody_defines_this;
