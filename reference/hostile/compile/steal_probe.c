#if __has_include("@SECRET@")
int probe;
#else
#error the secret is not to be seen
#endif
