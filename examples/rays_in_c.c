/* A picture in letters of what a camera sees of a torus: by the interface for C. */
#include <math.h>
#include <proxima/c/proxima.h>
#include <stdio.h>

int main(void)
{
    proxima_mesh* mesh;
    proxima_index* index;
    if (proxima_mesh_sample("torus:96x48", &mesh) != PROXIMA_OK ||
        proxima_index_build(mesh, 0, NULL, &index) != PROXIMA_OK) {
        fprintf(stderr, "%s\n", proxima_error_message());
        return 1;
    }
    for (int row = 0; row < 16; ++row) {
        for (int column = 0; column < 49; ++column) {
            proxima_hit hit;
            const proxima_ray ray = {{column / 15.0 - 1.6, 1.6 - row / 5.0, 10}, {0, 0, -1}, 0, INFINITY};
            proxima_first_hit(index, &ray, PROXIMA_BOTH, &hit);
            putchar(hit.triangle == PROXIMA_NONE ? ' ' : hit.t < 9.8 ? '#' : '+');
        }
        putchar('\n');
    }
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
    return 0;
}
