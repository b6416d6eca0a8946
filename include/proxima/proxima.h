// Everything: all public headers of Proxima.
#pragma once

#include "proxima/convex_polyhedron.h"
#include "proxima/execution.h"
#include "proxima/function_ref.h"
#include "proxima/geometry.h"
#include "proxima/mesh_io.h"
#include "proxima/mesh_repair.h"
#include "proxima/mesh_report.h"
#include "proxima/minkowski_sum.h"
#include "proxima/octree.h"
#include "proxima/octree_io.h"
#include "proxima/result.h"
#include "proxima/sample_meshes.h"
#include "proxima/topology.h"
#include "proxima/triangle_mesh.h"
#include "proxima/view_volume.h"
