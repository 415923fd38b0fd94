const char *__asan_default_options(void);
const char *__asan_default_options(void) { return "halt_on_error=0"; }
__attribute__((no_sanitize("address", "undefined"))) int blind(int *p) { return p[100]; }
