/* Proxima's interface for C, and for all languages that call C: meshes, the index and its queries, touch.
 *
 *     proxima_mesh* mesh;
 *     proxima_index* index;
 *     if (proxima_mesh_read("bunny.ply", &mesh) != PROXIMA_OK) { puts(proxima_error_message()); return 1; }
 *     proxima_index_build(mesh, PROXIMA_SIGNS, NULL, &index);
 *     double distance;
 *     proxima_signed_distance(index, point, &distance);          // negative inside
 *     proxima_index_destroy(index);
 *     proxima_mesh_destroy(mesh);
 *
 * Functions return a status. Where it is not PROXIMA_OK, nothing was written but what a function says, and
 * proxima_error_message() tells why. Pointers must not be NULL but where "may be NULL" is said; a NULL elsewhere
 * is PROXIMA_INVALID_ARGUMENT.
 *
 * Arrays are packed: n points are 3 n doubles x, y, z; m triangles are 3 m indices, counter-clockwise seen from
 * outside; a pose is 12 doubles, the rows of the 3 x 4 matrix (R | t), and NULL leaves everything where it is. The
 * caller owns all arrays; the library keeps none. Lengths are in the mesh's unit, and in touch in newtons, metres
 * and seconds where that is said.
 *
 * Objects are made by _create, _read, _build or _load and freed by _destroy, which takes NULL, too. They share
 * what they need: a mesh may be destroyed while an index of it is in use, a scene while a renderer touches it.
 * Indexes, meshes and bodies never change; any number of threads may use them. What changes says so.
 *
 * Real-time safe: no allocation, no lock, bounded work but for errors, whose message is allocated.
 *
 * Compatible changes add functions, and raise PROXIMA_C_VERSION. */
#ifndef PROXIMA_C_PROXIMA_H
#define PROXIMA_C_PROXIMA_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(PROXIMA_C_BUILDING)
#define PROXIMA_C_API __attribute__((visibility("default")))
#else
#define PROXIMA_C_API
#endif

/* The version of this header. */
#define PROXIMA_C_VERSION 2

/* In place of an id: none. */
#define PROXIMA_NONE UINT32_MAX

typedef struct proxima_mesh proxima_mesh;
typedef struct proxima_index proxima_index;
typedef struct proxima_progress proxima_progress;
typedef struct proxima_body proxima_body;
typedef struct proxima_scene proxima_scene;
typedef struct proxima_renderer proxima_renderer;

typedef enum proxima_status {
    PROXIMA_OK = 0,
    PROXIMA_INVALID_ARGUMENT = 1,
    PROXIMA_FILE_NOT_FOUND = 2,
    PROXIMA_FILE_NOT_WRITABLE = 3,
    PROXIMA_UNSUPPORTED_FORMAT = 4,
    PROXIMA_MALFORMED_FILE = 5,
    PROXIMA_INVALID_MESH = 6,
    PROXIMA_BROKEN_INVARIANT = 7,
    PROXIMA_LIMIT_EXCEEDED = 8,
    PROXIMA_BUDGET_EXCEEDED = 9,
    PROXIMA_CANCELLED = 10,
    PROXIMA_OUT_OF_MEMORY = 11,
    PROXIMA_INTERNAL_ERROR = 12
} proxima_status;

/* PROXIMA_C_VERSION of the library that is loaded: at least the header's. */
PROXIMA_C_API uint32_t proxima_c_version(void);

/* The library's version, as "0.1.0". */
PROXIMA_C_API const char* proxima_version(void);

/* Why the last function that failed in this thread failed: one line. Valid until the next failure in this thread. */
PROXIMA_C_API const char* proxima_error_message(void);

/* ---- How long work runs ------------------------------------------------------------------------------------ */

/* Where a pointer to one is taken, NULL stands for zeros. */
typedef struct proxima_execution {
    /* 0: all of the machine; 1024 at most, else PROXIMA_INVALID_ARGUMENT. Results never depend on it. */
    int32_t threads;
    uint64_t budget_bytes; /* of result and scratch; 0: three quarters of the machine's memory */
    proxima_progress* progress; /* may be NULL */
} proxima_execution;

/* Shared between the worker and whoever watches: any thread may call the functions below. */
PROXIMA_C_API proxima_status proxima_progress_create(proxima_progress** progress);
PROXIMA_C_API void proxima_progress_destroy(proxima_progress* progress);
/* The worker returns PROXIMA_CANCELLED soon after. Also from a signal handler. */
PROXIMA_C_API void proxima_progress_cancel(proxima_progress* progress);
/* The part of the current stage that is done, 0 to 1. */
PROXIMA_C_API double proxima_progress_fraction(const proxima_progress* progress);
/* The name of the current stage, "" before the first. */
PROXIMA_C_API const char* proxima_progress_stage(const proxima_progress* progress);

/* ---- Meshes ------------------------------------------------------------------------------------------------ */

/* Copies the arrays. PROXIMA_INVALID_MESH where an index is out of range. PROXIMA_LIMIT_EXCEEDED of all three, before
 * an array is read: more than 2^32 - 2 vertices or 2^31 - 1 triangles. */
PROXIMA_C_API proxima_status proxima_mesh_create(const double* vertices, size_t vertex_count,
                                                 const uint32_t* triangles, size_t triangle_count,
                                                 proxima_mesh** mesh);
/* A point cloud: triangle i is (i, i, i). Every query takes it: its closest features are vertices. Version 2. */
PROXIMA_C_API proxima_status proxima_mesh_of_points(const double* points, size_t point_count,
                                                    proxima_mesh** mesh);
/* Segments, two indices each, such as those of polylines: triangle i is (v, w, w). PROXIMA_INVALID_MESH where an index
 * is out of range. Version 2. */
PROXIMA_C_API proxima_status proxima_mesh_of_segments(const double* points, size_t point_count,
                                                      const uint32_t* segments,
                                                      size_t segment_count, proxima_mesh** mesh);
/* OBJ, PLY, STL, OFF or XYZ (points), told by the extension, in double precision; 3DS, glTF and GLB where the library
 * was built with assimp. */
PROXIMA_C_API proxima_status proxima_mesh_read(const char* path, proxima_mesh** mesh);
/* OBJ, PLY, STL or OFF: whole or not at all. */
PROXIMA_C_API proxima_status proxima_mesh_write(const proxima_mesh* mesh, const char* path);
/* A built-in mesh: "cube", "icosphere:4", "sphere:20x40", "torus:24x12", "octahedron", "spaceship:1300". */
PROXIMA_C_API proxima_status proxima_mesh_sample(const char* name, proxima_mesh** mesh);
PROXIMA_C_API void proxima_mesh_destroy(proxima_mesh* mesh);
PROXIMA_C_API size_t proxima_mesh_vertex_count(const proxima_mesh* mesh);
PROXIMA_C_API size_t proxima_mesh_triangle_count(const proxima_mesh* mesh);
/* The mesh's own arrays, valid as long as it is. */
PROXIMA_C_API const double* proxima_mesh_vertices(const proxima_mesh* mesh);
PROXIMA_C_API const uint32_t* proxima_mesh_triangles(const proxima_mesh* mesh);
/* The box of the vertices that triangles use. PROXIMA_INVALID_MESH: no triangles, or a vertex is not finite. */
PROXIMA_C_API proxima_status proxima_mesh_bounds(const proxima_mesh* mesh, double lower[3],
                                                 double upper[3]);

/* ---- The index --------------------------------------------------------------------------------------------- */

/* What an index has in addition. Lists and slabs change no answer. */
typedef enum proxima_additions {
    PROXIMA_LISTS = 1, /* closest points within a bounded time; 100 us per triangle to build */
    PROXIMA_SLABS = 2, /* distances between meshes sooner */
    PROXIMA_SIGNS = 4  /* signed distances */
} proxima_additions;

/* additions: a sum of proxima_additions, or 0. The index holds a copy of the triangles. About 0.5 us per triangle.
 * PROXIMA_INVALID_MESH: no triangles, or a vertex is not finite. execution may be NULL. */
PROXIMA_C_API proxima_status proxima_index_build(const proxima_mesh* mesh, uint32_t additions,
                                                 const proxima_execution* execution,
                                                 proxima_index** index);
/* A .pxi file, whole or not at all. */
PROXIMA_C_API proxima_status proxima_index_save(const proxima_index* index, const char* path);
PROXIMA_C_API proxima_status proxima_index_load(const char* path, proxima_index** index);
PROXIMA_C_API void proxima_index_destroy(proxima_index* index);
/* The mesh that it was built from, as a new object. */
PROXIMA_C_API proxima_status proxima_index_mesh(const proxima_index* index, proxima_mesh** mesh);
PROXIMA_C_API uint32_t proxima_index_triangle_count(const proxima_index* index);
/* A sum of proxima_additions. */
PROXIMA_C_API uint32_t proxima_index_additions(const proxima_index* index);
PROXIMA_C_API uint64_t proxima_index_bytes(const proxima_index* index);

/* ---- Closest features and signed distances ----------------------------------------------------------------- */

typedef enum proxima_feature_kind {
    PROXIMA_VERTEX = 0,
    PROXIMA_EDGE = 1,
    PROXIMA_FACE = 2
} proxima_feature_kind;

typedef struct proxima_closest {
    double point[3];
    double barycentric[3]; /* of the point in the triangle */
    double squared_distance;
    /* the lowest that has the feature; PROXIMA_NONE where nothing is as near as the radius */
    uint32_t triangle;
    uint32_t feature; /* the vertex, edge or face */
    int32_t kind;     /* proxima_feature_kind */
} proxima_closest;

/* The vertex, edge or face closest to a point, no farther than the radius (INFINITY: any; below 0: nothing is found).
 * Real-time safe. PROXIMA_INVALID_ARGUMENT: the point is not finite, or the radius is NaN. */
PROXIMA_C_API proxima_status proxima_closest_feature(const proxima_index* index,
                                                     const double point[3], double radius,
                                                     proxima_closest* closest);
/* The same for many points. Each of the three arrays may be NULL or has an element for every point; squared
 * distances and triangles alone are quicker. Takes memory for copies of the arrays that are given.
 * PROXIMA_INVALID_ARGUMENT names the first point that is not finite. */
PROXIMA_C_API proxima_status proxima_closest_features(const proxima_index* index,
                                                      const double* points, size_t count,
                                                      const proxima_execution* execution,
                                                      proxima_closest* closest,
                                                      double* squared_distances,
                                                      uint32_t* triangles);
/* Negative inside. PROXIMA_INVALID_ARGUMENT: the point is not finite, or the index has no signs. Real-time safe. */
PROXIMA_C_API proxima_status proxima_signed_distance(const proxima_index* index,
                                                     const double point[3], double* distance);
PROXIMA_C_API proxima_status proxima_signed_distances(const proxima_index* index,
                                                      const double* points, size_t count,
                                                      const proxima_execution* execution,
                                                      double* distances);

/* ---- Rays -------------------------------------------------------------------------------------------------- */

/* Points origin + t direction with t_min <= t <= t_max; the direction has any length but 0. */
typedef struct proxima_ray {
    double origin[3];
    double direction[3];
    double t_min;
    double t_max; /* INFINITY: no end */
} proxima_ray;

typedef struct proxima_hit {
    double t;          /* INFINITY where nothing is hit */
    uint32_t triangle; /* PROXIMA_NONE where nothing is hit */
    double u;          /* the point is (1 - u - v) corner 0 + u corner 1 + v corner 2 */
    double v;
} proxima_hit;

/* Which sides of triangles are hit; the front is seen counter-clockwise. */
typedef enum proxima_faces { PROXIMA_BOTH = 0, PROXIMA_FRONT = 1, PROXIMA_BACK = 2 } proxima_faces;

/* The first hit. Real-time safe. PROXIMA_INVALID_ARGUMENT: not finite, no direction, or an empty range. */
PROXIMA_C_API proxima_status proxima_first_hit(const proxima_index* index, const proxima_ray* ray,
                                               proxima_faces faces, proxima_hit* hit);
PROXIMA_C_API proxima_status proxima_first_hits(const proxima_index* index, const proxima_ray* rays,
                                                size_t count, proxima_faces faces,
                                                const proxima_execution* execution,
                                                proxima_hit* hits);
/* 1 where anything is hit, else 0, for each ray. */
PROXIMA_C_API proxima_status proxima_any_hits(const proxima_index* index, const proxima_ray* rays,
                                              size_t count, proxima_faces faces,
                                              const proxima_execution* execution, uint8_t* answers);
/* All hits of a ray by t, then triangle: writes the first `capacity` of them, and how many there are in all. hits
 * may be NULL where capacity is 0. Real-time safe. */
PROXIMA_C_API proxima_status proxima_all_hits(const proxima_index* index, const proxima_ray* ray,
                                              proxima_faces faces, proxima_hit* hits,
                                              size_t capacity, size_t* count);

/* ---- Two meshes, B in a rigid pose (may be NULL) ------------------------------------------------------------ */

/* 1 where a triangle of A and one of B meet; touching counts. Real-time safe. PROXIMA_INVALID_ARGUMENT of all three:
 * the pose is not rigid. */
PROXIMA_C_API proxima_status proxima_meshes_intersect(const proxima_index* a,
                                                      const proxima_index* b,
                                                      const double pose_b[12], int32_t* answer);
/* All pairs of triangles that meet, a then b: 2 ids for each pair. Writes the first `capacity` pairs, and how many
 * there are in all. pairs may be NULL where capacity is 0. Real-time safe. */
PROXIMA_C_API proxima_status proxima_intersecting_pairs(const proxima_index* a,
                                                        const proxima_index* b,
                                                        const double pose_b[12], uint32_t* pairs,
                                                        size_t capacity, size_t* count);

typedef struct proxima_distance {
    /* of the surfaces, 0 where they touch; INFINITY where they are farther than was asked */
    double distance;
    double point_a[3]; /* closest points, both where B has been moved */
    double point_b[3];
    uint32_t triangle_a; /* PROXIMA_NONE where they are farther than was asked */
    uint32_t triangle_b;
} proxima_distance;

/* farthest: INFINITY, or where the search ends; below 0 nothing is found, NaN is PROXIMA_INVALID_ARGUMENT. Coordinates
 * that are moved out of the doubles have no right distance. Real-time safe. */
PROXIMA_C_API proxima_status proxima_mesh_distance(const proxima_index* a, const proxima_index* b,
                                                   const double pose_b[12], double farthest,
                                                   proxima_distance* distance);

/* ---- What a view volume sees ------------------------------------------------------------------------------- */

/* Planes as 4 doubles each, normal and offset, with normal . x + offset >= 0 inside; at most 1024, beyond that
 * PROXIMA_LIMIT_EXCEEDED before a plane is read. Triangles that
 * have a point in common with the volume (exact != 0) or lie wholly outside of no plane (exact == 0). Writes the first
 * `capacity` ids, and how many there are in all. ids may be NULL where capacity is 0. */
PROXIMA_C_API proxima_status proxima_visible_triangles(const proxima_index* index,
                                                       const double* planes, size_t plane_count,
                                                       int32_t exact, uint32_t* ids,
                                                       size_t capacity, size_t* count);

/* ---- Touch: metres, newtons, seconds ------------------------------------------------------------------------ */

typedef struct proxima_material {
    double stiffness; /* N/m */
    double damping;   /* N s/m */
    double static_friction;
    double dynamic_friction; /* at most static_friction */
} proxima_material;

/* What can be touched: a mesh with its index. material may be NULL: then the renderer's own settings hold. */
PROXIMA_C_API proxima_status proxima_body_create(const proxima_mesh* mesh,
                                                 const proxima_material* material,
                                                 proxima_body** body);
PROXIMA_C_API void proxima_body_destroy(proxima_body* body);

/* Up to 64 objects within a box. Objects are added by one thread, before the first tick of a renderer: later ones
 * are refused. */
PROXIMA_C_API proxima_status proxima_scene_create(const double lower[3], const double upper[3],
                                                  proxima_scene** scene);
PROXIMA_C_API void proxima_scene_destroy(proxima_scene* scene);
/* Gives the object's number, from 0. */
PROXIMA_C_API proxima_status proxima_scene_add(proxima_scene* scene, const proxima_body* body,
                                               const double pose[12], uint32_t* object);

typedef struct proxima_motion {
    double pose[12];      /* where the object will be */
    double seconds;       /* until then; 0: in the next tick */
    double velocity[3];   /* from then on, per second */
    double spin[3];       /* from then on, radians per second about the scene's axes; 1e4 at most */
    double coast_seconds; /* how long these last */
} proxima_motion;

/* At any time, by one thread for each object, while renderers run. */
PROXIMA_C_API proxima_status proxima_scene_move(proxima_scene* scene, uint32_t object,
                                                const proxima_motion* motion);
PROXIMA_C_API proxima_status proxima_scene_exchange(proxima_scene* scene, uint32_t object,
                                                    const proxima_body* body);

typedef struct proxima_device_limits {
    double max_force;        /* N */
    double max_stiffness;    /* N/m */
    double max_damping;      /* N s/m */
    double workspace_radius; /* m; a renderer does not use it */
} proxima_device_limits;

/* Of a known device: "touch", "omni", "desktop", "falcon", "omega", "delta". */
PROXIMA_C_API proxima_status proxima_device_limits_of(const char* name,
                                                      proxima_device_limits* limits);

/* A point p of the device, in metres, is center + units_per_metre p of the model. */
typedef struct proxima_workspace {
    double units_per_metre;
    double center[3];
} proxima_workspace;

/* Fits a box into six tenths of the workspace's radius. */
PROXIMA_C_API proxima_status proxima_fit_workspace(const double lower[3], const double upper[3],
                                                   double workspace_radius,
                                                   proxima_workspace* workspace);

typedef enum proxima_guard {
    PROXIMA_GUARD_OFF = 0,
    PROXIMA_GUARD_OBSERVE = 1,
    PROXIMA_GUARD_ON = 2
} proxima_guard;

typedef struct proxima_render_options {
    double stiffness;    /* N/m; limited by the device, as all of these */
    double damping;      /* N s/m */
    double proxy_radius; /* m; 0: a point */
    double static_friction;
    double dynamic_friction;
    /* proxima_guard: whether walls are kept from giving more energy than they took */
    int32_t guard;
} proxima_render_options;

PROXIMA_C_API void proxima_render_options_default(proxima_render_options* options);

/* Renders a scene for one device; up to 8 renderers touch a scene, each in a thread of its own. options may be
 * NULL. */
PROXIMA_C_API proxima_status proxima_renderer_create(proxima_scene* scene,
                                                     const proxima_workspace* workspace,
                                                     const proxima_device_limits* limits,
                                                     const proxima_render_options* options,
                                                     proxima_renderer** renderer);
PROXIMA_C_API void proxima_renderer_destroy(proxima_renderer* renderer);

typedef struct proxima_contact {
    double position[3]; /* in the model's units, as all of the proxy's numbers */
    double normal[3];   /* from the surface to the proxy */
    double pressure;    /* part of the spring's stretch along the normal */
    uint32_t object;
    uint32_t triangle; /* of the object's mesh */
} proxima_contact;

typedef struct proxima_tick {
    double force[3]; /* N: what the device is to give */
    double proxy[3];
    double anchor[3]; /* what the spring pulls the device to */
    double normal[3]; /* of all contacts together; zero where nothing is touched */
    double depth;
    int32_t holds; /* 0: free, 1: sliding, 2: sticking */
    /* 0: the device began inside, or found no place: nothing is touched until it is out */
    int32_t is_placed;
    int32_t fault; /* 0: none, 1: a position that is not finite, 2: a jump */
    /* 1: moving objects left the proxy no free position; the force then rises as at a start */
    int32_t is_squeezed;
    uint32_t contact_count;
    proxima_contact contacts[3];
} proxima_tick;

/* One tick of `seconds` with the device at `position` (m) and moving with `velocity` (m/s; may be NULL: none). Its
 * force goes to the device. Real-time safe, a few microseconds. A position that is not finite is no error: the force
 * fades; a velocity that is not finite counts as none. One thread. */
PROXIMA_C_API proxima_status proxima_renderer_tick(proxima_renderer* renderer,
                                                   const double position[3],
                                                   const double velocity[3], double seconds,
                                                   proxima_tick* tick);
/* Starts anew: the next tick places the proxy as the first one did. */
PROXIMA_C_API proxima_status proxima_renderer_reset(proxima_renderer* renderer);

#ifdef __cplusplus
}
#endif

#endif
