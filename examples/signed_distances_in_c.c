/* How far points are from a sphere, negative inside: by the interface for C. */
#include <proxima/c/proxima.h>
#include <stdio.h>

int main(void)
{
    proxima_mesh* mesh;
    proxima_index* index;
    const double points[3][3] = {{0, 0, 3}, {0.2, 0.1, 0}, {0.6, 0, 0.8}};
    double distances[3];
    if (proxima_mesh_sample("icosphere:5", &mesh) != PROXIMA_OK ||
        proxima_index_build(mesh, PROXIMA_SIGNS, NULL, &index) != PROXIMA_OK ||
        proxima_signed_distances(index, points[0], 3, NULL, distances) != PROXIMA_OK) {
        fprintf(stderr, "%s\n", proxima_error_message());
        return 1;
    }
    for (int i = 0; i < 3; ++i) printf("%.3f\n", distances[i]);
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
    return 0;
}
