# 1 "/etc/passwd" 1
this is an error
