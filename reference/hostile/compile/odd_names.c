/* Names of the C library, of the interpreter and of the shim. */
int glob = 1, index_ = 1, environ_ = 1;
double y1 = 1;
int Py_IsInitialized(void);
int Py_IsInitialized(void) { return 0; }
void *dlopen(const char *name, int how);
void *dlopen(const char *name, int how) { return (void *)name + how; }
