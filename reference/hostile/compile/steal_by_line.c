/* The compiler shows the source line of an error: of which file? */
#line 1 "@SECRET@"
this is an error
