// Proxima in C# and Unity: meshes, points, segments, the index and its questions, touch. Put this file into Assets, and libproxima_c.so
// (proxima_c.dll, libproxima_c.dylib) into Assets/Plugins.
//
//     using (var mesh = new Proxima.TriangleMesh(vertices, triangles))
//     using (var index = new Proxima.MeshIndex(mesh, Proxima.Additions.Signs)) {
//         double distance = index.SignedDistance(new Proxima.Vector(0, 0, 2));        // negative inside
//     }
//
// Numbers are taken as Unity has them: its triangles run clockwise in left-handed axes, which are the same numbers as
// counter-clockwise in right-handed ones. Failures are ProximaException with the library's message. Queries of one
// point, one ray and one tick allocate nothing. Indexes may be used by any thread, a TouchRenderer by one at a time.
using System;
using System.Runtime.InteropServices;

namespace Proxima
{
    public sealed class ProximaException : Exception
    {
        public readonly int Status;
        public ProximaException(int status, string message) : base(message) { Status = status; }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Vector
    {
        public double X, Y, Z;
        public Vector(double x, double y, double z) { X = x; Y = y; Z = z; }
        public override string ToString()
        {
            return string.Format(System.Globalization.CultureInfo.InvariantCulture, "({0:g6}, {1:g6}, {2:g6})", X, Y, Z);
        }
    }

    /// The rows of the 3 x 4 matrix (R | t).
    [StructLayout(LayoutKind.Sequential)]
    public struct Pose
    {
        public double Xx, Xy, Xz, X, Yx, Yy, Yz, Y, Zx, Zy, Zz, Z;
        public static Pose At(Vector place)
        {
            return new Pose { Xx = 1, Yy = 1, Zz = 1, X = place.X, Y = place.Y, Z = place.Z };
        }
    }

    [Flags]
    public enum Additions : uint { None = 0, Lists = 1, Slabs = 2, Signs = 4 }
    public enum FeatureKind { Vertex = 0, Edge = 1, Face = 2 }
    public enum Faces { Both = 0, Front = 1, Back = 2 }

    [StructLayout(LayoutKind.Sequential)]
    public struct Closest
    {
        public Vector Point, Barycentric;
        public double SquaredDistance;
        public uint Triangle, Feature; ///< uint.MaxValue where nothing is as near as the radius
        public FeatureKind Kind;
        public bool IsFound { get { return Triangle != uint.MaxValue; } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct QueryRay
    {
        public Vector Origin, Direction;
        public double Least, Most;
        public QueryRay(Vector origin, Vector direction)
        {
            Origin = origin;
            Direction = direction;
            Least = 0;
            Most = double.PositiveInfinity;
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Hit
    {
        public double T;
        public uint Triangle;
        public double U, V;
        public bool IsHit { get { return Triangle != uint.MaxValue; } }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Distance
    {
        public double Length;
        public Vector PointA, PointB;
        public uint TriangleA, TriangleB;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Motion
    {
        public Pose Pose;
        public double Seconds;
        public Vector Velocity, Spin;
        public double CoastSeconds;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct DeviceLimits
    {
        public double MaxForce, MaxStiffness, MaxDamping, WorkspaceRadius;
        public static DeviceLimits Of(string device)
        {
            DeviceLimits limits;
            Native.Check(Native.proxima_device_limits_of(Native.Utf8(device), out limits));
            return limits;
        }
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Workspace
    {
        public double UnitsPerMetre;
        public Vector Center;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Contact
    {
        public Vector Position, Normal;
        public double Pressure;
        public uint Object, Triangle;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Tick
    {
        public Vector Force, Proxy, Anchor, Normal; ///< force in newtons, the rest in the model's units
        public double Depth;
        public int Holds, IsPlaced, Fault, IsSqueezed;
        public uint ContactCount;
        public Contact Contact0, Contact1, Contact2;
    }

    public sealed class TriangleMesh : IDisposable
    {
        internal readonly Handle Handle;
        internal TriangleMesh(Handle handle) { Handle = handle; }
        public TriangleMesh(double[] vertices, uint[] triangles)
        {
            if (vertices.Length % 3 != 0) throw new ArgumentException("the number of coordinates is no multiple of 3", "vertices");
            if (triangles.Length % 3 != 0) throw new ArgumentException("the number of indices is no multiple of 3", "triangles");
            IntPtr made;
            Native.Check(Native.proxima_mesh_create(vertices, (UIntPtr)(vertices.Length / 3), triangles,
                                                    (UIntPtr)(triangles.Length / 3), out made));
            Handle = new Handle(made, Native.proxima_mesh_destroy);
        }
        /// A point cloud: triangle i is point i. Every query takes it.
        public static TriangleMesh OfPoints(Vector[] points)
        {
            IntPtr made;
            Native.Check(Native.proxima_mesh_of_points(points, (UIntPtr)points.Length, out made));
            return new TriangleMesh(new Handle(made, Native.proxima_mesh_destroy));
        }
        /// Segments between points, two indices each, such as those of polylines: triangle i is segment i.
        public static TriangleMesh OfSegments(Vector[] points, uint[] segments)
        {
            if (segments.Length % 2 != 0) throw new ArgumentException("the number of indices is no multiple of 2", "segments");
            IntPtr made;
            Native.Check(Native.proxima_mesh_of_segments(points, (UIntPtr)points.Length, segments,
                                                         (UIntPtr)(segments.Length / 2), out made));
            return new TriangleMesh(new Handle(made, Native.proxima_mesh_destroy));
        }
        public static TriangleMesh Read(string path)
        {
            IntPtr made;
            Native.Check(Native.proxima_mesh_read(Native.Utf8(path), out made));
            return new TriangleMesh(new Handle(made, Native.proxima_mesh_destroy));
        }
        public static TriangleMesh Sample(string name)
        {
            IntPtr made;
            Native.Check(Native.proxima_mesh_sample(Native.Utf8(name), out made));
            return new TriangleMesh(new Handle(made, Native.proxima_mesh_destroy));
        }
        public void Dispose() { Handle.Dispose(); }
    }

    public sealed class MeshIndex : IDisposable
    {
        internal readonly Handle Handle;
        public MeshIndex(TriangleMesh mesh, Additions additions)
        {
            IntPtr made;
            Native.Check(Native.proxima_index_build(mesh.Handle, (uint)additions, IntPtr.Zero, out made));
            Handle = new Handle(made, Native.proxima_index_destroy);
        }
        public Closest ClosestFeature(Vector point, double radius = double.PositiveInfinity)
        {
            Closest found;
            Native.Check(Native.proxima_closest_feature(Handle, ref point, radius, out found));
            return found;
        }
        public double SignedDistance(Vector point)
        {
            double distance;
            Native.Check(Native.proxima_signed_distance(Handle, ref point, out distance));
            return distance;
        }
        /// On all threads.
        public void SignedDistances(Vector[] points, double[] distances)
        {
            if (distances.Length < points.Length) throw new ArgumentException("an element for each point", "distances");
            Native.Check(Native.proxima_signed_distances(Handle, points, (UIntPtr)points.Length, IntPtr.Zero, distances));
        }
        public Hit FirstHit(QueryRay ray, Faces faces = Faces.Both)
        {
            Hit hit;
            Native.Check(Native.proxima_first_hit(Handle, ref ray, faces, out hit));
            return hit;
        }
        public bool Intersects(MeshIndex other, Pose poseOfOther)
        {
            int answer;
            Native.Check(Native.proxima_meshes_intersect(Handle, other.Handle, ref poseOfOther, out answer));
            return answer != 0;
        }
        public Distance DistanceTo(MeshIndex other, Pose poseOfOther, double farthest = double.PositiveInfinity)
        {
            Distance distance;
            Native.Check(Native.proxima_mesh_distance(Handle, other.Handle, ref poseOfOther, farthest, out distance));
            return distance;
        }
        public void Dispose() { Handle.Dispose(); }
    }

    public sealed class TouchScene : IDisposable
    {
        internal readonly Handle Handle;
        public TouchScene(Vector lower, Vector upper)
        {
            IntPtr made;
            Native.Check(Native.proxima_scene_create(ref lower, ref upper, out made));
            Handle = new Handle(made, Native.proxima_scene_destroy);
        }
        /// Before the first tick of a renderer. Gives the object's number.
        public uint Add(TriangleMesh mesh, Pose pose)
        {
            IntPtr body;
            Native.Check(Native.proxima_body_create(mesh.Handle, IntPtr.Zero, out body));
            using (var handle = new Handle(body, Native.proxima_body_destroy)) {
                uint added;
                Native.Check(Native.proxima_scene_add(Handle, handle, ref pose, out added));
                return added;
            }
        }
        public void Move(uint number, Motion motion)
        {
            Native.Check(Native.proxima_scene_move(Handle, number, ref motion));
        }
        public void Dispose() { Handle.Dispose(); }
    }

    public sealed class TouchRenderer : IDisposable
    {
        internal readonly Handle Handle;
        public TouchRenderer(TouchScene scene, Workspace workspace, DeviceLimits limits)
        {
            IntPtr made;
            Native.Check(Native.proxima_renderer_create(scene.Handle, ref workspace, ref limits, IntPtr.Zero, out made));
            Handle = new Handle(made, Native.proxima_renderer_destroy);
        }
        /// One tick with the device at a position (m) and a velocity (m/s): call it 1,000 times a second, in a thread of its own.
        public void Step(Vector position, Vector velocity, double seconds, out Tick tick)
        {
            Native.Check(Native.proxima_renderer_tick(Handle, ref position, ref velocity, seconds, out tick));
        }
        public void Dispose() { Handle.Dispose(); }
    }

    /// A pointer of the library, freed once.
    public sealed class Handle : SafeHandle
    {
        private readonly Action<IntPtr> destroy;
        internal Handle(IntPtr made, Action<IntPtr> destroy) : base(IntPtr.Zero, true)
        {
            this.destroy = destroy;
            SetHandle(made);
        }
        public override bool IsInvalid { get { return handle == IntPtr.Zero; } }
        protected override bool ReleaseHandle()
        {
            destroy(handle);
            return true;
        }
    }

    internal static class Native
    {
        private const string Library = "proxima_c";

        internal static void Check(int status)
        {
            if (status != 0) throw new ProximaException(status, Text(proxima_error_message()));
        }

        /// Texts are UTF-8 with a zero at the end.
        internal static byte[] Utf8(string text)
        {
            return System.Text.Encoding.UTF8.GetBytes(text + '\0');
        }
        private static string Text(IntPtr text)
        {
            int length = 0;
            while (Marshal.ReadByte(text, length) != 0) ++length;
            var bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return System.Text.Encoding.UTF8.GetString(bytes);
        }

        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] private static extern IntPtr proxima_error_message();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_create(double[] vertices, UIntPtr vertexCount,
            uint[] triangles, UIntPtr triangleCount, out IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_of_points(Vector[] points, UIntPtr pointCount,
            out IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_of_segments(Vector[] points, UIntPtr pointCount,
            uint[] segments, UIntPtr segmentCount, out IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_read(byte[] path, out IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_sample(byte[] name, out IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern void proxima_mesh_destroy(IntPtr mesh);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_index_build(Handle mesh, uint additions, IntPtr execution,
            out IntPtr index);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern void proxima_index_destroy(IntPtr index);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_closest_feature(Handle index, ref Vector point,
            double radius, out Closest closest);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_signed_distance(Handle index, ref Vector point,
            out double distance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_signed_distances(Handle index, Vector[] points,
            UIntPtr count, IntPtr execution, [Out] double[] distances);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_first_hit(Handle index, ref QueryRay ray, Faces faces,
            out Hit hit);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_meshes_intersect(Handle a, Handle b, ref Pose poseOfB,
            out int answer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_mesh_distance(Handle a, Handle b, ref Pose poseOfB,
            double farthest, out Distance distance);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_body_create(Handle mesh, IntPtr material, out IntPtr body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern void proxima_body_destroy(IntPtr body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_scene_create(ref Vector lower, ref Vector upper,
            out IntPtr scene);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern void proxima_scene_destroy(IntPtr scene);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_scene_add(Handle scene, Handle body, ref Pose pose,
            out uint added);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_scene_move(Handle scene, uint number, ref Motion motion);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_device_limits_of(byte[] name, out DeviceLimits limits);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_renderer_create(Handle scene, ref Workspace workspace,
            ref DeviceLimits limits, IntPtr options, out IntPtr renderer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern void proxima_renderer_destroy(IntPtr renderer);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)] internal static extern int proxima_renderer_tick(Handle renderer, ref Vector position,
            ref Vector velocity, double seconds, out Tick tick);
    }
}
