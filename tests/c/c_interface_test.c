/* The C interface as a C program uses it: every function once where it works and once where it must refuse, with answers
 * that are known in advance.
 *
 *     c_interface_test FOLDER      writes files there; prints each check that fails; exit status 1 if any */
#include "proxima/c/proxima.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;
static int checks = 0;

#define CHECK(holds)                                                                               \
    do {                                                                                           \
        ++checks;                                                                                  \
        if (!(holds)) {                                                                            \
            ++failures;                                                                            \
            printf("%s:%d: %s; last message: %s\n", __FILE__, __LINE__, #holds,                    \
                   proxima_error_message());                                                       \
        }                                                                                          \
    } while (0)

/* The call fails with this status, and says why in these words. */
#define REFUSES(call, status, words)                                                               \
    do {                                                                                           \
        CHECK((call) == (status));                                                                 \
        CHECK(strstr(proxima_error_message(), (words)) != NULL);                                   \
    } while (0)

static int is_near(double value, double expected)
{
    return fabs(value - expected) <= 1e-12 * (1 + fabs(expected));
}

/* An octahedron's triangles are those of the points with |x| + |y| + |z| = 1. */
static const double octahedron[] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
static const uint32_t faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};

static proxima_mesh* make_octahedron(void)
{
    proxima_mesh* mesh = NULL;
    CHECK(proxima_mesh_create(octahedron, 6, faces, 8, &mesh) == PROXIMA_OK);
    return mesh;
}

static proxima_index* index_of(const proxima_mesh* mesh)
{
    proxima_index* index = NULL;
    CHECK(proxima_index_build(mesh, PROXIMA_SIGNS | PROXIMA_LISTS | PROXIMA_SLABS, NULL, &index) == PROXIMA_OK);
    return index;
}

static void test_versions(void)
{
    CHECK(proxima_c_version() == PROXIMA_C_VERSION);
    CHECK(strchr(proxima_version(), '.') != NULL);
}

static void test_meshes(const char* folder)
{
    char path[1024];
    double lower[3], upper[3];
    proxima_mesh* read = NULL;
    proxima_mesh* mesh = make_octahedron();
    CHECK(proxima_mesh_vertex_count(mesh) == 6 && proxima_mesh_triangle_count(mesh) == 8);
    CHECK(memcmp(proxima_mesh_vertices(mesh), octahedron, sizeof octahedron) == 0);
    CHECK(memcmp(proxima_mesh_triangles(mesh), faces, sizeof faces) == 0);
    CHECK(proxima_mesh_bounds(mesh, lower, upper) == PROXIMA_OK && lower[2] == -1 && upper[1] == 1);

    snprintf(path, sizeof path, "%s/octahedron.ply", folder);
    CHECK(proxima_mesh_write(mesh, path) == PROXIMA_OK);
    CHECK(proxima_mesh_read(path, &read) == PROXIMA_OK);
    CHECK(memcmp(proxima_mesh_vertices(read), octahedron, sizeof octahedron) == 0);
    proxima_mesh_destroy(read);
    read = NULL;
    snprintf(path, sizeof path, "%s/missing/octahedron.ply", folder);
    REFUSES(proxima_mesh_write(mesh, path), PROXIMA_FILE_NOT_WRITABLE, "missing");
    REFUSES(proxima_mesh_read(path, &read), PROXIMA_FILE_NOT_FOUND, "missing");
    REFUSES(proxima_mesh_write(mesh, "a.xyz"), PROXIMA_UNSUPPORTED_FORMAT, "a.xyz");
    CHECK(read == NULL);
    proxima_mesh_destroy(mesh);

    CHECK(proxima_mesh_sample("icosphere:2", &mesh) == PROXIMA_OK && proxima_mesh_triangle_count(mesh) == 320);
    proxima_mesh_destroy(mesh);
    REFUSES(proxima_mesh_sample("teapot", &mesh), PROXIMA_INVALID_ARGUMENT, "teapot");
    REFUSES(proxima_mesh_sample("tea\npot", &mesh), PROXIMA_INVALID_ARGUMENT, "tea pot");

    const uint32_t beyond[] = {0, 1, 6};
    REFUSES(proxima_mesh_create(octahedron, 6, beyond, 1, &mesh), PROXIMA_INVALID_MESH, "triangle 0 uses vertex 6");
    REFUSES(proxima_mesh_create(NULL, 6, faces, 8, &mesh), PROXIMA_INVALID_ARGUMENT, "NULL");
    REFUSES(proxima_mesh_create(octahedron, 6, faces, 8, NULL), PROXIMA_INVALID_ARGUMENT, "NULL");

    /* Kept as a value, refused by what computes with it. */
    const double bad[] = {0, 0, 0, 1, 0, 0, 0, NAN, 0};
    const uint32_t one[] = {0, 1, 2};
    proxima_index* index = NULL;
    CHECK(proxima_mesh_create(bad, 3, one, 1, &mesh) == PROXIMA_OK);
    REFUSES(proxima_mesh_bounds(mesh, lower, upper), PROXIMA_INVALID_MESH, "vertex 2");
    REFUSES(proxima_index_build(mesh, 0, NULL, &index), PROXIMA_INVALID_MESH, "vertex 2");
    proxima_mesh_destroy(mesh);
    CHECK(proxima_mesh_create(NULL, 0, NULL, 0, &mesh) == PROXIMA_OK);
    CHECK(proxima_mesh_vertices(mesh) == NULL && proxima_mesh_triangles(mesh) == NULL);
    REFUSES(proxima_index_build(mesh, 0, NULL, &index), PROXIMA_INVALID_MESH, "");
    proxima_mesh_destroy(mesh);
    proxima_mesh_destroy(NULL);
}

static void test_points_and_segments(void)
{
    proxima_mesh* mesh = NULL;
    proxima_index* index = NULL;
    proxima_closest closest;
    const double p[] = {0.5, 0.125, 0.25};
    const uint32_t ends[] = {0, 1, 5, 4}, beyond[] = {0, 6};

    CHECK(proxima_mesh_of_points(octahedron, 6, &mesh) == PROXIMA_OK && proxima_mesh_triangle_count(mesh) == 6);
    CHECK(memcmp(proxima_mesh_vertices(mesh), octahedron, sizeof octahedron) == 0);
    for (uint32_t i = 0; i < 18; ++i) CHECK(proxima_mesh_triangles(mesh)[i] == i / 3);
    CHECK(proxima_index_build(mesh, 0, NULL, &index) == PROXIMA_OK);
    proxima_mesh_destroy(mesh);
    CHECK(proxima_closest_feature(index, p, INFINITY, &closest) == PROXIMA_OK);
    CHECK(closest.kind == PROXIMA_VERTEX && closest.point[0] == octahedron[3 * closest.feature]);
    CHECK(closest.squared_distance == 0.25 + 0.015625 + 0.0625);
    proxima_index_destroy(index);

    CHECK(proxima_mesh_of_segments(octahedron, 6, ends, 2, &mesh) == PROXIMA_OK && proxima_mesh_triangle_count(mesh) == 2);
    const uint32_t corners[] = {0, 1, 1, 5, 4, 4};
    CHECK(memcmp(proxima_mesh_triangles(mesh), corners, sizeof corners) == 0);
    CHECK(proxima_index_build(mesh, 0, NULL, &index) == PROXIMA_OK);
    proxima_mesh_destroy(mesh);
    CHECK(proxima_closest_feature(index, p, INFINITY, &closest) == PROXIMA_OK && closest.kind == PROXIMA_EDGE);
    proxima_index_destroy(index);

    mesh = NULL;
    REFUSES(proxima_mesh_of_segments(octahedron, 6, beyond, 1, &mesh), PROXIMA_INVALID_MESH, "segment 0 uses point 6");
    REFUSES(proxima_mesh_of_segments(octahedron, 6, NULL, 1, &mesh), PROXIMA_INVALID_ARGUMENT, "NULL");
    REFUSES(proxima_mesh_of_points(NULL, 6, &mesh), PROXIMA_INVALID_ARGUMENT, "NULL");
    /* limits are checked before any element is read */
    const size_t counts[] = {(size_t)1 << 32, (size_t)1 << 60, (size_t)-1};
    for (int i = 0; i < 3; ++i) {
        REFUSES(proxima_mesh_of_points(octahedron, counts[i], &mesh), PROXIMA_LIMIT_EXCEEDED, "2^31 - 1 points");
        REFUSES(proxima_mesh_of_segments(octahedron, counts[i], ends, 2, &mesh), PROXIMA_LIMIT_EXCEEDED, "2^32 - 2 vertices");
        REFUSES(proxima_mesh_of_segments(octahedron, 6, ends, counts[i], &mesh), PROXIMA_LIMIT_EXCEEDED, "2^31 - 1 segments");
        REFUSES(proxima_mesh_create(octahedron, counts[i], faces, 8, &mesh), PROXIMA_LIMIT_EXCEEDED, "2^32 - 2 vertices");
        REFUSES(proxima_mesh_create(octahedron, 6, faces, counts[i], &mesh), PROXIMA_LIMIT_EXCEEDED, "2^31 - 1 triangles");
    }
    REFUSES(proxima_mesh_of_points(octahedron, 6, NULL), PROXIMA_INVALID_ARGUMENT, "NULL");
    CHECK(mesh == NULL);
}

static void test_index(const char* folder)
{
    char path[1024];
    proxima_mesh* mesh = make_octahedron();
    proxima_index* index = index_of(mesh);
    proxima_index* loaded = NULL;
    proxima_mesh* again = NULL;
    proxima_mesh_destroy(mesh);
    CHECK(proxima_index_triangle_count(index) == 8 && proxima_index_bytes(index) > 8 * 9 * sizeof(double));
    CHECK(proxima_index_additions(index) == (PROXIMA_SIGNS | PROXIMA_LISTS | PROXIMA_SLABS));
    snprintf(path, sizeof path, "%s/octahedron.pxi", folder);
    CHECK(proxima_index_save(index, path) == PROXIMA_OK);
    CHECK(proxima_index_load(path, &loaded) == PROXIMA_OK);
    CHECK(proxima_index_additions(loaded) == proxima_index_additions(index));
    CHECK(proxima_index_mesh(loaded, &again) == PROXIMA_OK);
    CHECK(memcmp(proxima_mesh_vertices(again), octahedron, sizeof octahedron) == 0);
    REFUSES(proxima_index_build(again, 8, NULL, &loaded), PROXIMA_INVALID_ARGUMENT, "additions");
    proxima_mesh_destroy(again);
    proxima_index_destroy(loaded);
    proxima_index_destroy(index);
    snprintf(path, sizeof path, "%s/octahedron.ply", folder);
    REFUSES(proxima_index_load(path, &loaded), PROXIMA_UNSUPPORTED_FORMAT, "octahedron.ply");
}

static void test_execution(void)
{
    proxima_mesh* mesh = NULL;
    proxima_index* index = NULL;
    proxima_progress* progress = NULL;
    CHECK(proxima_mesh_sample("icosphere:4", &mesh) == PROXIMA_OK);
    CHECK(proxima_progress_create(&progress) == PROXIMA_OK);
    CHECK(strcmp(proxima_progress_stage(progress), "") == 0);
    proxima_execution execution = {2, 0, progress};
    CHECK(proxima_index_build(mesh, 0, &execution, &index) == PROXIMA_OK);
    CHECK(strcmp(proxima_progress_stage(progress), "") != 0 && proxima_progress_fraction(progress) == 1);
    proxima_index_destroy(index);
    proxima_progress_cancel(progress);
    REFUSES(proxima_index_build(mesh, 0, &execution, &index), PROXIMA_CANCELLED, "");
    proxima_progress_destroy(progress);
    proxima_execution small = {0, 1000, NULL};
    REFUSES(proxima_index_build(mesh, 0, &small, &index), PROXIMA_BUDGET_EXCEEDED, "");

    const proxima_execution most = {1024, 0, NULL};
    CHECK(proxima_index_build(mesh, PROXIMA_SIGNS, &most, &index) == PROXIMA_OK);
    const int32_t wrong[] = {-1, 1025, INT32_MIN, INT32_MAX};
    const double point[] = {0, 0, 2};
    const proxima_ray ray = {{0, 0, 2}, {0, 0, -1}, 0, INFINITY};
    for (int i = 0; i < 4; ++i) {
        const proxima_execution bad = {wrong[i], 0, NULL};
        proxima_index* none = NULL;
        double distance = 7;
        proxima_hit hit;
        uint8_t any = 7;
        REFUSES(proxima_index_build(mesh, 0, &bad, &none), PROXIMA_INVALID_ARGUMENT, "threads: must be from 0 to 1024");
        REFUSES(proxima_closest_features(index, point, 1, &bad, NULL, &distance, NULL), PROXIMA_INVALID_ARGUMENT, "threads");
        REFUSES(proxima_signed_distances(index, point, 1, &bad, &distance), PROXIMA_INVALID_ARGUMENT, "threads");
        REFUSES(proxima_first_hits(index, &ray, 1, PROXIMA_BOTH, &bad, &hit), PROXIMA_INVALID_ARGUMENT, "threads");
        REFUSES(proxima_any_hits(index, &ray, 1, PROXIMA_BOTH, &bad, &any), PROXIMA_INVALID_ARGUMENT, "threads");
        CHECK(none == NULL && distance == 7 && any == 7);
    }
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
}

static void test_closest(void)
{
    proxima_mesh* mesh = make_octahedron();
    proxima_index* index = index_of(mesh);
    proxima_index* plain = NULL;
    const double points[] = {2, 0, 0, 0.5, 0.5, 2, 1, 1, 1, 0, 0, 0.25};
    proxima_closest closest, many[4];
    double squared[4], distances[4], distance;
    uint32_t triangles[4];
    CHECK(proxima_index_build(mesh, 0, NULL, &plain) == PROXIMA_OK);

    CHECK(proxima_closest_feature(index, points, INFINITY, &closest) == PROXIMA_OK);
    CHECK(closest.kind == PROXIMA_VERTEX && closest.feature == 0 && closest.squared_distance == 1 && closest.triangle == 0);
    CHECK(closest.point[0] == 1 && closest.point[1] == 0 && closest.point[2] == 0);
    CHECK(proxima_closest_feature(index, points + 6, INFINITY, &closest) == PROXIMA_OK);
    CHECK(closest.kind == PROXIMA_FACE && closest.feature == 0 && is_near(closest.squared_distance, 4.0 / 3));
    CHECK(is_near(closest.barycentric[0], 1.0 / 3) && is_near(closest.point[2], 1.0 / 3));
    CHECK(proxima_closest_feature(index, points, 0.5, &closest) == PROXIMA_OK);
    CHECK(closest.triangle == PROXIMA_NONE && isnan(closest.squared_distance));
    const double nowhere[] = {0, NAN, 0};
    REFUSES(proxima_closest_feature(index, nowhere, INFINITY, &closest), PROXIMA_INVALID_ARGUMENT, "finite");
    closest.triangle = 77;
    REFUSES(proxima_closest_feature(index, points, NAN, &closest), PROXIMA_INVALID_ARGUMENT, "radius: is NaN");
    CHECK(closest.triangle == 77);
    CHECK(proxima_closest_feature(index, points, -1, &closest) == PROXIMA_OK && closest.triangle == PROXIMA_NONE);

    CHECK(proxima_closest_features(index, points, 4, NULL, many, squared, triangles) == PROXIMA_OK);
    for (int i = 0; i < 4; ++i) {
        CHECK(proxima_closest_feature(plain, points + 3 * i, INFINITY, &closest) == PROXIMA_OK);
        CHECK(memcmp(&closest, &many[i], sizeof closest) == 0);
        CHECK(squared[i] == closest.squared_distance && triangles[i] == closest.triangle);
    }
    CHECK(proxima_closest_features(index, points, 4, NULL, NULL, NULL, triangles) == PROXIMA_OK);
    CHECK(proxima_closest_features(index, NULL, 0, NULL, NULL, NULL, NULL) == PROXIMA_OK);
    REFUSES(proxima_closest_features(index, points, (size_t)-1 / 8 + 1, NULL, NULL, NULL, NULL), PROXIMA_OUT_OF_MEMORY, "count");
    REFUSES(proxima_closest_features(index, nowhere, 1, NULL, NULL, squared, NULL), PROXIMA_INVALID_ARGUMENT, "point 0");
    /* what cannot be answered leaves the arrays as they were */
    const double one_of_two[] = {0, 0, 3, NAN, 0, 0};
    squared[0] = distances[0] = many[0].squared_distance = -1;
    triangles[0] = 77;
    REFUSES(proxima_closest_features(index, one_of_two, 2, NULL, many, squared, triangles), PROXIMA_INVALID_ARGUMENT, "point 1");
    REFUSES(proxima_signed_distances(index, one_of_two, 2, NULL, distances), PROXIMA_INVALID_ARGUMENT, "point 1");
    CHECK(squared[0] == -1 && distances[0] == -1 && many[0].squared_distance == -1 && triangles[0] == 77);

    CHECK(proxima_signed_distances(index, points, 4, NULL, distances) == PROXIMA_OK);
    CHECK(distances[0] == 1 && is_near(distances[3], -0.75 / sqrt(3)));
    for (int i = 0; i < 4; ++i) {
        CHECK(proxima_signed_distance(index, points + 3 * i, &distance) == PROXIMA_OK);
        CHECK(distance == distances[i]);
    }
    REFUSES(proxima_signed_distance(plain, points, &distance), PROXIMA_INVALID_ARGUMENT, "signs");
    REFUSES(proxima_signed_distances(plain, points, 4, NULL, distances), PROXIMA_INVALID_ARGUMENT, "signs");
    proxima_index_destroy(plain);
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
}

static void test_rays(void)
{
    proxima_mesh* mesh = make_octahedron();
    proxima_index* index = index_of(mesh);
    const proxima_ray rays[] = {{{0.25, 0.25, 5}, {0, 0, -2}, 0, INFINITY},
                                {{0.25, 0.25, 5}, {0, 0, 1}, 0, INFINITY},
                                {{0.25, 0.25, 0}, {0, 0, 1}, 0, INFINITY}};
    const proxima_ray none = {{0, 0, 0}, {0, 0, 0}, 0, 1};
    proxima_hit hit, hits[3];
    uint8_t any[3];
    size_t count = 0;
    CHECK(proxima_first_hit(index, &rays[0], PROXIMA_BOTH, &hit) == PROXIMA_OK);
    CHECK(hit.triangle == 0 && hit.t == 2.25 && is_near(hit.u, 0.25) && is_near(hit.v, 0.5));
    CHECK(proxima_first_hit(index, &rays[0], PROXIMA_BACK, &hit) == PROXIMA_OK && hit.triangle == 4 && hit.t == 2.75);
    CHECK(proxima_first_hits(index, rays, 3, PROXIMA_BOTH, NULL, hits) == PROXIMA_OK);
    CHECK(hits[0].t == 2.25 && hits[1].triangle == PROXIMA_NONE && isinf(hits[1].t) && hits[2].t == 0.5);
    CHECK(proxima_any_hits(index, rays, 3, PROXIMA_FRONT, NULL, any) == PROXIMA_OK);
    CHECK(any[0] == 1 && any[1] == 0 && any[2] == 0);
    CHECK(proxima_all_hits(index, &rays[0], PROXIMA_BOTH, hits, 1, &count) == PROXIMA_OK);
    CHECK(count == 2 && hits[0].t == 2.25 && hits[1].triangle == PROXIMA_NONE);
    CHECK(proxima_all_hits(index, &rays[0], PROXIMA_BOTH, hits, 3, &count) == PROXIMA_OK && hits[1].t == 2.75);
    CHECK(proxima_all_hits(index, &rays[1], PROXIMA_BOTH, NULL, 0, &count) == PROXIMA_OK && count == 0);
    CHECK(proxima_first_hits(index, rays, 3, PROXIMA_FRONT, NULL, hits) == PROXIMA_OK);
    CHECK(hits[0].t == 2.25 && hits[1].triangle == PROXIMA_NONE && hits[2].triangle == PROXIMA_NONE);
    CHECK(proxima_first_hits(index, rays, 3, PROXIMA_BACK, NULL, hits) == PROXIMA_OK);
    CHECK(hits[0].t == 2.75 && hits[1].triangle == PROXIMA_NONE && hits[2].t == 0.5);
    CHECK(proxima_all_hits(index, &rays[0], PROXIMA_FRONT, hits, 3, &count) == PROXIMA_OK && count == 1 && hits[0].t == 2.25);
    CHECK(proxima_all_hits(index, &rays[0], PROXIMA_BACK, hits, 3, &count) == PROXIMA_OK && count == 1 && hits[0].t == 2.75);
    proxima_ray late = rays[0]; /* begins between the two */
    late.t_min = 2.5;
    CHECK(proxima_first_hit(index, &late, PROXIMA_BOTH, &hit) == PROXIMA_OK && hit.triangle == 4 && hit.t == 2.75);
    CHECK(proxima_first_hits(index, &late, 1, PROXIMA_BOTH, NULL, hits) == PROXIMA_OK && hits[0].t == 2.75);
    CHECK(proxima_all_hits(index, &late, PROXIMA_BOTH, hits, 3, &count) == PROXIMA_OK && count == 1 && hits[0].t == 2.75);
    REFUSES(proxima_first_hit(index, &none, PROXIMA_BOTH, &hit), PROXIMA_INVALID_ARGUMENT, "direction");
    proxima_ray nan = rays[0];
    nan.t_max = NAN;
    REFUSES(proxima_first_hit(index, &nan, PROXIMA_BOTH, &hit), PROXIMA_INVALID_ARGUMENT, "finite");
    REFUSES(proxima_all_hits(index, &nan, PROXIMA_BOTH, hits, 3, &count), PROXIMA_INVALID_ARGUMENT, "finite");
    REFUSES(proxima_first_hits(index, &none, 1, PROXIMA_BOTH, NULL, hits), PROXIMA_INVALID_ARGUMENT, "ray 0");
    REFUSES(proxima_any_hits(index, rays, 3, (proxima_faces)3, NULL, any), PROXIMA_INVALID_ARGUMENT, "faces");
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
}

static int has_corner(uint32_t triangle, uint32_t vertex)
{
    for (uint32_t i = 0; i < 3; ++i)
        if (triangle < 8 && faces[3 * triangle + i] == vertex) return 1;
    return 0;
}

static void test_two_meshes(void)
{
    proxima_mesh* mesh = make_octahedron();
    proxima_index* index = index_of(mesh);
    double pose[] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0};
    proxima_distance distance;
    uint32_t pairs[64];
    size_t count = 0;
    int32_t meet = -1;
    CHECK(proxima_meshes_intersect(index, index, pose, &meet) == PROXIMA_OK && meet == 0);
    CHECK(proxima_mesh_distance(index, index, pose, INFINITY, &distance) == PROXIMA_OK);
    CHECK(distance.distance == 3 && distance.point_a[0] == 1 && distance.point_b[0] == 4);
    CHECK(has_corner(distance.triangle_a, 0) && has_corner(distance.triangle_b, 1)); /* at x = 1 and x = -1 */
    CHECK(proxima_mesh_distance(index, index, pose, 2, &distance) == PROXIMA_OK);
    CHECK(isinf(distance.distance) && distance.triangle_a == PROXIMA_NONE);
    distance.distance = 7;
    REFUSES(proxima_mesh_distance(index, index, pose, NAN, &distance), PROXIMA_INVALID_ARGUMENT, "farthest: is NaN");
    CHECK(distance.distance == 7);
    CHECK(proxima_mesh_distance(index, index, pose, -1, &distance) == PROXIMA_OK && distance.triangle_a == PROXIMA_NONE);
    pose[3] = 2; /* a corner at a corner */
    CHECK(proxima_meshes_intersect(index, index, pose, &meet) == PROXIMA_OK && meet == 1);
    CHECK(proxima_intersecting_pairs(index, index, pose, pairs, 32, &count) == PROXIMA_OK && count == 16);
    CHECK(pairs[0] == 0 && pairs[1] == 1);
    CHECK(proxima_intersecting_pairs(index, index, pose, NULL, 0, &count) == PROXIMA_OK && count == 16);
    CHECK(proxima_meshes_intersect(index, index, NULL, &meet) == PROXIMA_OK && meet == 1);
    pose[0] = 2;
    REFUSES(proxima_meshes_intersect(index, index, pose, &meet), PROXIMA_INVALID_ARGUMENT, "");
    REFUSES(proxima_intersecting_pairs(index, index, pose, pairs, 32, &count), PROXIMA_INVALID_ARGUMENT, "");
    REFUSES(proxima_mesh_distance(index, NULL, NULL, 1, &distance), PROXIMA_INVALID_ARGUMENT, "NULL");

    const double planes[] = {1, 0, 0, -0.5, 0, 1, 0, -0.25}; /* x >= 0.5, y >= 0.25 */
    uint32_t ids[8];
    CHECK(proxima_visible_triangles(index, planes, 2, 1, ids, 8, &count) == PROXIMA_OK);
    CHECK(count == 2 && ((ids[0] == 0 && ids[1] == 4) || (ids[0] == 4 && ids[1] == 0)));
    CHECK(proxima_visible_triangles(index, planes, 2, 0, NULL, 0, &count) == PROXIMA_OK && count >= 2);
    const double beside[] = {1, 0, 0, -0.5, 0, 1, 0, -0.75}; /* x >= 0.5, y >= 0.75: two triangles reach into each, none into both */
    CHECK(proxima_visible_triangles(index, beside, 2, 1, ids, 8, &count) == PROXIMA_OK && count == 0);
    CHECK(proxima_visible_triangles(index, beside, 2, 0, ids, 8, &count) == PROXIMA_OK && count == 2);
    CHECK((ids[0] == 0 && ids[1] == 4) || (ids[0] == 4 && ids[1] == 0));
    REFUSES(proxima_visible_triangles(index, NULL, 2, 1, ids, 8, &count), PROXIMA_INVALID_ARGUMENT, "NULL");
    /* the limit is checked before any plane is read */
    double most[4 * 1024];
    for (int i = 0; i < 4 * 1024; ++i) most[i] = planes[i % 8];
    CHECK(proxima_visible_triangles(index, most, 1024, 1, ids, 8, &count) == PROXIMA_OK && count == 2);
    const size_t too_many[] = {1025, 100000000, (size_t)1 << 60, (size_t)-1};
    for (int i = 0; i < 4; ++i) {
        REFUSES(proxima_visible_triangles(index, planes, too_many[i], 1, ids, 8, &count), PROXIMA_LIMIT_EXCEEDED, "at most 1024 planes, not 1");
    }
    proxima_index_destroy(index);
    proxima_mesh_destroy(mesh);
}

/* A block of 0.1 m, pressed from above: after a second the force is that of the spring. */
static void test_touch(void)
{
    const double lower[] = {-1, -1, -1}, upper[] = {1, 1, 1};
    proxima_mesh* cube = NULL;
    proxima_mesh* block = NULL;
    proxima_body* body = NULL;
    proxima_scene* scene = NULL;
    proxima_renderer* renderer = NULL;
    proxima_device_limits limits;
    proxima_workspace workspace;
    proxima_render_options options;
    proxima_tick tick;
    uint32_t object = 7;
    double corners[24];
    CHECK(proxima_mesh_sample("cube", &cube) == PROXIMA_OK && proxima_mesh_vertex_count(cube) == 8);
    double low[3], high[3];
    CHECK(proxima_mesh_bounds(cube, low, high) == PROXIMA_OK);
    for (int i = 0; i < 24; ++i) {
        const double at = (proxima_mesh_vertices(cube)[i] - low[i % 3]) / (high[i % 3] - low[i % 3]);
        corners[i] = 0.1 * at - 0.05;
    }
    CHECK(proxima_mesh_create(corners, 8, proxima_mesh_triangles(cube), proxima_mesh_triangle_count(cube), &block) == PROXIMA_OK);

    const proxima_material material = {300, 1, 0.2, 0.1}, wrong = {300, 1, 0.1, 0.2};
    REFUSES(proxima_body_create(block, &wrong, &body), PROXIMA_INVALID_ARGUMENT, "friction");
    for (int i = 0; i < 4; ++i) {
        proxima_material nan = material;
        *(i == 0 ? &nan.stiffness : i == 1 ? &nan.damping : i == 2 ? &nan.static_friction : &nan.dynamic_friction) = NAN;
        REFUSES(proxima_body_create(block, &nan, &body), PROXIMA_INVALID_ARGUMENT, "");
    }
    CHECK(proxima_body_create(block, &material, &body) == PROXIMA_OK);
    REFUSES(proxima_scene_create(upper, lower, &scene), PROXIMA_INVALID_ARGUMENT, "box");
    REFUSES(proxima_scene_create(lower, lower, &scene), PROXIMA_INVALID_ARGUMENT, "flat");
    CHECK(proxima_scene_create(lower, upper, &scene) == PROXIMA_OK);
    CHECK(proxima_scene_add(scene, body, NULL, &object) == PROXIMA_OK && object == 0);
    CHECK(proxima_device_limits_of("omega", &limits) == PROXIMA_OK && limits.max_stiffness > 300);
    REFUSES(proxima_device_limits_of("glove", &limits), PROXIMA_INVALID_ARGUMENT, "omega");
    CHECK(proxima_fit_workspace(lower, upper, limits.workspace_radius, &workspace) == PROXIMA_OK);
    CHECK(is_near(workspace.units_per_metre, sqrt(3.0) / (0.6 * limits.workspace_radius)));
    REFUSES(proxima_fit_workspace(lower, upper, 0, &workspace), PROXIMA_INVALID_ARGUMENT, "radius");
    REFUSES(proxima_fit_workspace(lower, upper, NAN, &workspace), PROXIMA_INVALID_ARGUMENT, "radius");
    const double far_lower[] = {-8e307, -8e307, -8e307}, far_upper[] = {8e307, 8e307, 8e307};
    REFUSES(proxima_fit_workspace(far_lower, far_upper, 0.05, &workspace), PROXIMA_INVALID_ARGUMENT, "large");
    workspace.units_per_metre = 1;
    proxima_render_options_default(&options);
    CHECK(options.guard == PROXIMA_GUARD_ON && options.proxy_radius == 0);
    options.guard = 5;
    REFUSES(proxima_renderer_create(scene, &workspace, &limits, &options, &renderer), PROXIMA_INVALID_ARGUMENT, "guard");
    proxima_render_options_default(&options);
    options.proxy_radius = NAN;
    REFUSES(proxima_renderer_create(scene, &workspace, &limits, &options, &renderer), PROXIMA_INVALID_ARGUMENT, "proxy_radius");
    CHECK(proxima_renderer_create(scene, &workspace, &limits, NULL, &renderer) == PROXIMA_OK);
    /* What they were made from is not needed any longer. */
    proxima_body_destroy(body);
    proxima_mesh_destroy(block);
    proxima_mesh_destroy(cube);

    double at[] = {0.01, 0.01, 0.06};
    for (int i = 0; i < 300; ++i) {
        CHECK(proxima_renderer_tick(renderer, at, NULL, 1e-3, &tick) == PROXIMA_OK);
        CHECK(tick.force[2] == 0 && tick.holds == 0 && tick.is_placed == 1);
    }
    for (int i = 0; i < 1000; ++i) {
        if (at[2] > 0.048) at[2] -= 1e-4;
        CHECK(proxima_renderer_tick(renderer, at, NULL, 1e-3, &tick) == PROXIMA_OK);
    }
    CHECK(fabs(tick.force[2] - 300 * (0.05 - at[2])) < 1e-3 && fabs(tick.force[0]) < 1e-3);
    CHECK(tick.holds == 2 && tick.contact_count == 1 && tick.contacts[0].object == 0 && tick.contacts[0].normal[2] > 0.999999);
    CHECK(fabs(tick.proxy[2] - 0.05) < 1e-6 && is_near(tick.normal[2], 1));

    /* The block sinks by a centimetre in half a second: then nothing is touched. */
    const proxima_motion motion = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -0.01}, 0.5, {0, 0, 0}, {0, 0, 0}, 0};
    CHECK(proxima_scene_move(scene, 0, &motion) == PROXIMA_OK);
    REFUSES(proxima_scene_move(scene, 1, &motion), PROXIMA_INVALID_ARGUMENT, "object");
    for (int i = 0; i < 4; ++i) {
        proxima_motion nan = motion;
        *(i == 0 ? &nan.seconds : i == 1 ? &nan.velocity[1] : i == 2 ? &nan.spin[2] : &nan.coast_seconds) = NAN;
        REFUSES(proxima_scene_move(scene, 0, &nan), PROXIMA_INVALID_ARGUMENT, "");
    }
    proxima_scene_destroy(scene); /* the renderer holds on to it */
    for (int i = 0; i < 600; ++i) CHECK(proxima_renderer_tick(renderer, at, NULL, 1e-3, &tick) == PROXIMA_OK);
    CHECK(tick.force[2] == 0 && tick.holds == 0);
    CHECK(proxima_renderer_reset(renderer) == PROXIMA_OK);
    const double lost[] = {NAN, 0, 0};
    CHECK(proxima_renderer_tick(renderer, at, at, 1e-3, &tick) == PROXIMA_OK && tick.fault == 0);
    CHECK(proxima_renderer_tick(renderer, lost, NULL, 1e-3, &tick) == PROXIMA_OK && tick.fault == 1);
    CHECK(proxima_renderer_tick(renderer, at, lost, 1e-3, &tick) == PROXIMA_OK && isfinite(tick.force[0]));
    REFUSES(proxima_renderer_tick(renderer, at, NULL, 0, &tick), PROXIMA_INVALID_ARGUMENT, "seconds");
    REFUSES(proxima_renderer_tick(renderer, at, NULL, NAN, &tick), PROXIMA_INVALID_ARGUMENT, "seconds");
    proxima_renderer_destroy(renderer);
}

static void test_devices(void)
{
    proxima_device_limits limits;
    CHECK(proxima_device_limits_of("omni", &limits) == PROXIMA_OK);
    CHECK(limits.max_force == 3.3 && limits.max_stiffness == 700);
    CHECK(limits.max_damping == 5 && limits.workspace_radius == 0.1);
}

static const proxima_material smooth = {300, 1, 0, 0};

static proxima_body* make_octahedral_body(double size)
{
    double corners[18];
    proxima_mesh* mesh = NULL;
    proxima_body* body = NULL;
    for (int i = 0; i < 18; ++i) corners[i] = size * octahedron[i];
    CHECK(proxima_mesh_create(corners, 6, faces, 8, &mesh) == PROXIMA_OK);
    CHECK(proxima_body_create(mesh, &smooth, &body) == PROXIMA_OK);
    proxima_mesh_destroy(mesh);
    return body;
}

/* Goes down to that point of the model from 2 cm above it, and stays there. */
static proxima_tick press(proxima_renderer* renderer, const proxima_workspace* workspace, const double point[3])
{
    proxima_tick tick = {0};
    CHECK(proxima_renderer_reset(renderer) == PROXIMA_OK);
    for (int i = 0; i < 1000; ++i) {
        double at[3];
        for (int k = 0; k < 3; ++k) at[k] = (point[k] - workspace->center[k]) / workspace->units_per_metre;
        if (i < 200) at[2] += 1e-4 * (200 - i);
        CHECK(proxima_renderer_tick(renderer, at, NULL, 1e-3, &tick) == PROXIMA_OK);
    }
    return tick;
}

/* What was pressed is a smooth octahedron's face 0, x + y + z = constant: its closest point is as far in x, y and z. */
static void check_pressed(const proxima_tick* tick, const proxima_workspace* workspace, const double point[3], double far)
{
    CHECK(tick->contact_count == 1 && tick->contacts[0].object == 0 && tick->contacts[0].triangle == 0);
    for (int k = 0; k < 3; ++k) {
        CHECK(fabs(tick->proxy[k] - (point[k] + far)) < 1e-6);
        CHECK(fabs(tick->force[k] - smooth.stiffness * far / workspace->units_per_metre) < 1e-3);
    }
}

/* A model that is not at the origin is in the middle of the device's workspace. */
static void test_workspace(void)
{
    const double lower[] = {0, 1, 2}, upper[] = {4, 5, 6}, there[] = {1, 0, 0, 2, 0, 1, 0, 3, 0, 0, 1, 4};
    const double point[] = {2.2, 3.1, 4.6}; /* 0.2 + 0.1 + 0.6 from the octahedron's middle: 0.1 too little */
    proxima_body* body = make_octahedral_body(1);
    proxima_scene* scene = NULL;
    proxima_renderer* renderer = NULL;
    proxima_device_limits limits;
    proxima_workspace workspace = {0, {0, 0, 0}};
    uint32_t object;
    CHECK(proxima_scene_create(lower, upper, &scene) == PROXIMA_OK);
    CHECK(proxima_scene_add(scene, body, there, &object) == PROXIMA_OK);
    CHECK(proxima_device_limits_of("omni", &limits) == PROXIMA_OK);
    CHECK(proxima_fit_workspace(lower, upper, limits.workspace_radius, &workspace) == PROXIMA_OK);
    CHECK(workspace.center[0] == 2 && workspace.center[1] == 3 && workspace.center[2] == 4);
    CHECK(is_near(workspace.units_per_metre, sqrt(12.0) / 0.06));
    CHECK(proxima_renderer_create(scene, &workspace, &limits, NULL, &renderer) == PROXIMA_OK);
    const proxima_tick tick = press(renderer, &workspace, point);
    check_pressed(&tick, &workspace, point, 0.1 / 3);
    proxima_renderer_destroy(renderer);
    proxima_scene_destroy(scene);
    proxima_body_destroy(body);
}

/* Two octahedra close on a hand between them from both sides. */
static void test_squeeze(void)
{
    const double lower[] = {-4, -4, -4}, upper[] = {4, 4, 4}, middle[] = {0, 0, 0};
    const double left[] = {1, 0, 0, -1.5, 0, 1, 0, 0, 0, 0, 1, 0}, right[] = {1, 0, 0, 1.5, 0, 1, 0, 0, 0, 0, 1, 0};
    const proxima_motion motion = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0.5, {0, 0, 0}, {0, 0, 0}, 0};
    const proxima_workspace workspace = {1, {0, 0, 0}};
    proxima_mesh* mesh = make_octahedron();
    proxima_body* body = NULL;
    proxima_scene* scene = NULL;
    proxima_renderer* renderer = NULL;
    proxima_device_limits limits;
    proxima_tick tick;
    uint32_t object;
    int squeezed = 0;
    CHECK(proxima_body_create(mesh, NULL, &body) == PROXIMA_OK);
    CHECK(proxima_scene_create(lower, upper, &scene) == PROXIMA_OK);
    CHECK(proxima_scene_add(scene, body, left, &object) == PROXIMA_OK);
    CHECK(proxima_scene_add(scene, body, right, &object) == PROXIMA_OK && object == 1);
    CHECK(proxima_device_limits_of("omega", &limits) == PROXIMA_OK);
    CHECK(proxima_renderer_create(scene, &workspace, &limits, NULL, &renderer) == PROXIMA_OK);
    CHECK(proxima_renderer_tick(renderer, middle, NULL, 1e-3, &tick) == PROXIMA_OK && tick.is_squeezed == 0);
    REFUSES(proxima_scene_add(scene, body, left, &object), PROXIMA_INVALID_ARGUMENT, "first tick");
    for (uint32_t i = 0; i < 2; ++i) CHECK(proxima_scene_move(scene, i, &motion) == PROXIMA_OK);
    for (int i = 0; i < 600; ++i) {
        CHECK(proxima_renderer_tick(renderer, middle, NULL, 1e-3, &tick) == PROXIMA_OK);
        squeezed += tick.is_squeezed;
    }
    CHECK(squeezed > 0);
    proxima_renderer_destroy(renderer);
    proxima_scene_destroy(scene);
    proxima_body_destroy(body);
    proxima_mesh_destroy(mesh);
}

/* An octahedron in place of one of half its size: what was free above it is inside. */
static void test_exchange(void)
{
    const double lower[] = {-2.25, -2.25, -2.25}, upper[] = {2.25, 2.25, 2.25}, out[] = {1, 0, 0, 1.5, 0, 1, 0, 0, 0, 0, 1, 0};
    const double point[] = {0.2, 0.1, 1.5};
    const proxima_workspace workspace = {100, {0, 0, 0}};
    proxima_body* body = make_octahedral_body(1);
    proxima_body* large = make_octahedral_body(2);
    proxima_body* too_large = make_octahedral_body(3);
    proxima_scene* scene = NULL;
    proxima_renderer* renderer = NULL;
    proxima_device_limits limits;
    uint32_t object;
    CHECK(proxima_scene_create(lower, upper, &scene) == PROXIMA_OK);
    REFUSES(proxima_scene_add(scene, body, out, &object), PROXIMA_INVALID_ARGUMENT, "bounds");
    REFUSES(proxima_scene_exchange(scene, 0, body), PROXIMA_INVALID_ARGUMENT, "object");
    CHECK(proxima_scene_add(scene, body, NULL, &object) == PROXIMA_OK);
    REFUSES(proxima_scene_exchange(scene, object, too_large), PROXIMA_INVALID_ARGUMENT, "bounds");
    CHECK(proxima_device_limits_of("omni", &limits) == PROXIMA_OK);
    CHECK(proxima_renderer_create(scene, &workspace, &limits, NULL, &renderer) == PROXIMA_OK);
    proxima_tick tick = press(renderer, &workspace, point);
    CHECK(tick.contact_count == 0 && tick.holds == 0 && tick.force[2] == 0 && is_near(tick.proxy[2], 1.5));
    CHECK(proxima_scene_exchange(scene, object, large) == PROXIMA_OK);
    tick = press(renderer, &workspace, point);
    check_pressed(&tick, &workspace, point, 0.2 / 3);
    proxima_renderer_destroy(renderer);
    proxima_scene_destroy(scene);
    proxima_body_destroy(too_large);
    proxima_body_destroy(large);
    proxima_body_destroy(body);
}

int main(int argc, char** argv)
{
    const char* folder = argc > 1 ? argv[1] : ".";
    CHECK(strcmp(proxima_error_message(), "") == 0);
    test_versions();
    test_meshes(folder);
    test_points_and_segments();
    test_index(folder);
    test_execution();
    test_closest();
    test_rays();
    test_two_meshes();
    test_touch();
    test_devices();
    test_workspace();
    test_squeeze();
    test_exchange();
    printf("%d checks, %d failed\n", checks, failures);
    return failures == 0 ? 0 : 1;
}
