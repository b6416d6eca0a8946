// What a program in C# asks: distances, rays, contact and a second of touch. Compiled and run with Mono by the tests.
using System;
using Proxima;

static class Questions
{
    static void Main()
    {
        using (var mesh = TriangleMesh.Sample("icosphere:5"))
        using (var cube = new TriangleMesh(new double[] {-1, -1, -1, 1, -1, -1, -1, 1, -1, -1, -1, 1},
                                   new uint[] {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3}))
        using (var index = new MeshIndex(mesh, Additions.Signs))
        using (var other = new MeshIndex(cube, Additions.None)) {
            var points = new[] {new Vector(0, 0, 3), new Vector(0.2, 0.1, 0), new Vector(0, 0, -1.5)};
            var distances = new double[3];
            index.SignedDistances(points, distances);
            Print("{0:f3} {1:f3} {2:f3}", distances[0], distances[1], distances[2]);
            Print("{0:f3} {1}", index.SignedDistance(points[0]), index.ClosestFeature(points[0]).IsFound);
            Print("{0}", index.ClosestFeature(points[0], 0.5).IsFound);
            Print("{0:f3} {1}", index.FirstHit(new QueryRay(points[0], new Vector(0, 0, -1))).T,
                  index.FirstHit(new QueryRay(points[0], new Vector(0, 0, 1))).IsHit);
            var away = Pose.At(new Vector(4, 0, 0));
            Print("{0} {1:f3}", index.Intersects(other, away), index.DistanceTo(other, away).Length);
            try {
                other.SignedDistance(points[0]);
            } catch (ProximaException error) {
                Print("{0}: {1}", error.Status, error.Message.Contains("signs"));
            }
            AskPointsAndSegments();
            using (var scene = new TouchScene(new Vector(-2, -2, -2), new Vector(2, 2, 2))) {
                scene.Add(mesh, Pose.At(new Vector()));
                var workspace = new Workspace {UnitsPerMetre = 20};
                using (var renderer = new TouchRenderer(scene, workspace, DeviceLimits.Of("omni"))) {
                    Tick tick = new Tick();
                    for (int i = 0; i <= 1000; ++i) {
                        double z = 0.055 - 0.000008 * i; // in metres: the surface is at 0.05
                        renderer.Step(new Vector(0, 0, z), new Vector(0, 0, -0.008), 0.001, out tick);
                    }
                    Print("pressed {0} N, {1} contact", tick.Force.Z > 0.5, tick.ContactCount);
                }
            }
        }
    }

    static void AskPointsAndSegments()
    {
        var corners = new[] {new Vector(0, 0, 0), new Vector(4, 0, 0), new Vector(4, 4, 0)};
        var near = new Vector(3, 1, 0);
        using (var cloud = TriangleMesh.OfPoints(corners))
        using (var path = TriangleMesh.OfSegments(corners, new uint[] {0, 1, 1, 2}))
        using (var points = new MeshIndex(cloud, Additions.None))
        using (var segments = new MeshIndex(path, Additions.None)) {
            var corner = points.ClosestFeature(near);
            Print("point {0}, {1:f3}", corner.Triangle, Math.Sqrt(corner.SquaredDistance));
            var segment = segments.ClosestFeature(new Vector(5, 1, 0));
            Print("segment {0}, {1}", segment.Triangle, segment.Point);
        }
        try {
            TriangleMesh.OfSegments(corners, new uint[] {0, 9});
        } catch (ProximaException error) {
            Print("{0}: {1}", error.Status, error.Message);
        }
    }

    static void Print(string format, params object[] values)
    {
        Console.WriteLine(string.Format(System.Globalization.CultureInfo.InvariantCulture, format, values));
    }
}
