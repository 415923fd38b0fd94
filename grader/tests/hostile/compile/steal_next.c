#include_next </../../../@SECRET@>
