// Proxima in Unreal Engine 5: an index of a mesh, asked in FVector and TArray. Put this header into a module's
// Public folder, include/proxima/c/proxima.h into Public/proxima/c, libproxima_c into its ThirdParty folder, and add both
// to its Build.cs:
//
//     PublicIncludePaths.Add(...);  PublicAdditionalLibraries.Add(".../libproxima_c.so");
//
//     FProximaIndex Index(Positions, Triangles, PROXIMA_SIGNS);
//     if (!Index.IsValid()) { UE_LOG(LogTemp, Error, TEXT("%s"), *Index.Error()); return; }
//     const double Distance = Index.SignedDistance(Point);                        // negative inside, in Unreal's centimetres
//
// Numbers are taken as Unreal has them. If distances come out positive inside, the triangles run the other way round: swap
// two corners of each. An index may be used by any thread, and queries of one point or ray allocate nothing.
#pragma once

#include "CoreMinimal.h"
#include "proxima/c/proxima.h"

#include <limits>

class FProximaIndex {
public:
    /// Additions: a sum of proxima_additions.
    FProximaIndex(const TArray<FVector>& Positions, const TArray<int32>& Triangles,
                  uint32 Additions = PROXIMA_SIGNS)
    {
        static_assert(sizeof(FVector) == 3 * sizeof(double),
                      "Unreal Engine 5 has vectors of doubles");
        if (Triangles.Num() % 3 != 0) {
            Why = FString(UTF8_TO_TCHAR("triangles: the number of indices is no multiple of 3"));
            return;
        }
        proxima_mesh* Mesh = nullptr;
        proxima_status Status = proxima_mesh_create(
            reinterpret_cast<const double*>(Positions.GetData()), Positions.Num(),
            reinterpret_cast<const uint32_t*>(Triangles.GetData()), Triangles.Num() / 3, &Mesh);
        if (Status == PROXIMA_OK) {
            Status = proxima_index_build(Mesh, Additions, nullptr, &Index);
        }
        if (Status != PROXIMA_OK) {
            Why = FString(UTF8_TO_TCHAR(proxima_error_message()));
        }
        proxima_mesh_destroy(Mesh);
    }
    ~FProximaIndex() { proxima_index_destroy(Index); }
    FProximaIndex(const FProximaIndex&) = delete;
    FProximaIndex& operator=(const FProximaIndex&) = delete;

    bool IsValid() const { return Index != nullptr; }
    /// Why it is not valid.
    const FString& Error() const { return Why; }

    /// False where nothing is as near as the radius, or the point is not finite.
    bool ClosestPoint(const FVector& Point, FVector& OutPoint, int32& OutTriangle,
                      double Radius = std::numeric_limits<double>::infinity()) const
    {
        proxima_closest Closest;
        if (proxima_closest_feature(Index, &Point.X, Radius, &Closest) != PROXIMA_OK ||
            Closest.triangle == PROXIMA_NONE) {
            return false;
        }
        OutPoint = FVector(Closest.point[0], Closest.point[1], Closest.point[2]);
        OutTriangle = static_cast<int32>(Closest.triangle);
        return true;
    }

    /// Negative inside; NaN where the point is not finite or the index was built without PROXIMA_SIGNS.
    double SignedDistance(const FVector& Point) const
    {
        double Distance = std::numeric_limits<double>::quiet_NaN();
        proxima_signed_distance(Index, &Point.X, &Distance);
        return Distance;
    }

    /// The first hit from Start to End, as a fraction of the way.
    bool LineTrace(const FVector& Start, const FVector& End, double& OutFraction,
                   int32& OutTriangle) const
    {
        const proxima_ray Ray = {{Start.X, Start.Y, Start.Z},
                                 {End.X - Start.X, End.Y - Start.Y, End.Z - Start.Z},
                                 0.0,
                                 1.0};
        proxima_hit Hit;
        if (proxima_first_hit(Index, &Ray, PROXIMA_BOTH, &Hit) != PROXIMA_OK ||
            Hit.triangle == PROXIMA_NONE) {
            return false;
        }
        OutFraction = Hit.t;
        OutTriangle = static_cast<int32>(Hit.triangle);
        return true;
    }

private:
    proxima_index* Index = nullptr;
    FString Why;
};
