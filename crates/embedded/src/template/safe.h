/* The commands that FAILED goes to. */
void @prefix@_safe(@prefix@_commands *out);

