/* The force of a plate on a hand that presses into it, a thousand times a second: by the interface for C. */
#include <proxima/c/proxima.h>
#include <stdio.h>

int main(void)
{
    const double corners[] = {-0.1, -0.1, 0, 0.1, -0.1, 0, 0.1, 0.1, 0, -0.1, 0.1, 0};
    const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    const double lower[] = {-1, -1, -1}, upper[] = {1, 1, 1};
    const proxima_workspace metres = {1, {0, 0, 0}};
    proxima_mesh* mesh;
    proxima_body* plate;
    proxima_scene* scene;
    proxima_renderer* renderer;
    proxima_device_limits limits;
    proxima_tick tick;
    uint32_t object;
    if (proxima_mesh_create(corners, 4, triangles, 2, &mesh) != PROXIMA_OK ||
        proxima_body_create(mesh, NULL, &plate) != PROXIMA_OK ||
        proxima_scene_create(lower, upper, &scene) != PROXIMA_OK ||
        proxima_scene_add(scene, plate, NULL, &object) != PROXIMA_OK ||
        proxima_device_limits_of("omega", &limits) != PROXIMA_OK ||
        proxima_renderer_create(scene, &metres, &limits, NULL, &renderer) != PROXIMA_OK) {
        fprintf(stderr, "%s\n", proxima_error_message());
        return 1;
    }
    for (int i = 0; i <= 1000; ++i) {
        const double hand[] = {0.01, 0.01, i < 500 ? 0.003 - 1e-5 * i : -0.002};
        proxima_renderer_tick(renderer, hand, NULL, 1e-3, &tick); /* then the force goes to the device */
        if (i % 250 == 0) printf("%4d ms %6.3f N\n", i, tick.force[2]);
    }
    proxima_renderer_destroy(renderer);
    proxima_scene_destroy(scene);
    proxima_body_destroy(plate);
    proxima_mesh_destroy(mesh);
    return 0;
}
