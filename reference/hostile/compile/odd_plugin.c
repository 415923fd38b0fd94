#pragma GCC plugin "/tmp/evil.so"
#pragma GCC optimize ("fplugin=/tmp/evil.so")
#pragma comment(lib, "/etc/passwd")
int harmless;
