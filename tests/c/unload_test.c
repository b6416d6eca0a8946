/* A program that opens the library, builds an index on all processors and closes the library while oneTBB's threads are
 * still looking for work, as a scripting runtime does at its end. Its calls must find the library again. */
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

typedef int (*sample_fn)(const char*, void**);
typedef int (*build_fn)(const void*, unsigned, const void*, void**);
typedef void (*destroy_fn)(void*);

static int find(void* library, const char* name, void* function)
{
  void* const symbol = dlsym(library, name);
  memcpy(function, &symbol, sizeof symbol);
  return symbol != NULL;
}

int main(int argc, char** argv)
{
  int round;
  for (round = 0; round < 20 && argc == 2; ++round) {
    sample_fn sample;
    build_fn build;
    destroy_fn destroy_mesh, destroy_index;
    void *mesh, *index;
    void* library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL || !find(library, "proxima_mesh_sample", &sample) || !find(library, "proxima_index_build", &build) ||
        !find(library, "proxima_mesh_destroy", &destroy_mesh) || !find(library, "proxima_index_destroy", &destroy_index)) {
      fprintf(stderr, "%s\n", dlerror());
      return 1;
    }
    if (sample("icosphere:5", &mesh) != 0 || build(mesh, 4, NULL, &index) != 0) {
      fprintf(stderr, "round %d: no index\n", round);
      return 1;
    }
    destroy_index(index);
    destroy_mesh(mesh);
    dlclose(library);
    library = dlopen(argv[1], RTLD_NOW | RTLD_NOLOAD);
    if (library == NULL) {
      fprintf(stderr, "round %d: the library is gone, and threads still run in it\n", round);
      return 1;
    }
    dlclose(library);
  }
  return argc == 2 ? 0 : 2;
}
