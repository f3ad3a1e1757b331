#include <engram/engram_c.h>
#include <stdio.h>

int main(void) {
  engram_env* env = NULL;
  if (engram_make("RememberColor3-VLA-v0", NULL, &env) != ENGRAM_OK ||
      engram_reset(env, NULL) != ENGRAM_OK) {
    fprintf(stderr, "%s\n", engram_last_error());
    return 1;
  }
  printf("C: engram %s, %d state values\n", engram_version(), engram_state_dim(env));
  engram_close(env);
  return 0;
}
