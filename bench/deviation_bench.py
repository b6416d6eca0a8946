"""The deviation of two meshes by `proxima deviation` and by VTK's vtkHausdorffDistancePointSetFilter, one thread each, in
processor time. VTK measures from vertices alone, and gives no bound of what is between them.

    deviation_bench.py PROXIMA [A B]...      by default pairs of built-in models
"""
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersModeling import vtkHausdorffDistancePointSetFilter

ROUNDS = 3
PAIRS = [["icosphere:4", "sphere:50x50"], ["icosphere:6", "sphere:190x190"], ["torus:264x132", "torus:260x134"],
         ["torus:264x132", "torus:264x132"]]


def seconds(who, work):
    """Median of the processor time of this process or of those it starts, and what the last round gave."""
    taken = []
    for _ in range(ROUNDS):
        before = resource.getrusage(who)
        answer = work()
        after = resource.getrusage(who)
        taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return statistics.median(taken), answer


def poly_data(proxima, model, folder):
    """The model as VTK has it, through a file of a format that is read in a few lines."""
    path = Path(folder) / "model.off"
    subprocess.run([proxima, "repair", model, "--no-weld", "--no-orient", "--no-outward", "--keep-unused", "--quiet", "--out", path], check=True)
    words = path.read_text().split()
    vertices, triangles = int(words[1]), int(words[2])
    points = np.array(words[4:4 + 3 * vertices], dtype=float).reshape(-1, 3)
    cells = np.array(words[4 + 3 * vertices:], dtype=np.int64)
    data = vtkPolyData()
    places = vtkPoints()
    places.SetDataTypeToDouble()
    places.SetData(numpy_to_vtk(points, deep=True))
    data.SetPoints(places)
    polygons = vtkCellArray()
    polygons.ImportLegacyFormat(numpy_to_vtkIdTypeArray(cells, deep=True))
    data.SetPolys(polygons)
    return data, triangles


def main():
    proxima = sys.argv[1]
    pairs = [sys.argv[i:i + 2] for i in range(2, len(sys.argv), 2)] or PAIRS
    vtkSMPTools.Initialize(1)
    print("| A, B | triangles | Hausdorff distance, Proxima | s | VTK, from vertices | s |")
    print("|---|---|---|---|---|---|")
    for a, b in pairs:
        with tempfile.TemporaryDirectory() as folder:
            (data_a, count_a), (data_b, count_b) = (poly_data(proxima, model, folder) for model in (a, b))

        def by_vtk():
            measure = vtkHausdorffDistancePointSetFilter()
            measure.SetInputData(0, data_a)
            measure.SetInputData(1, data_b)
            measure.SetTargetDistanceMethodToPointToCell()
            measure.Update()
            return measure.GetHausdorffDistance()

        def by_proxima():
            command = [proxima, "deviation", a, b, "--no-mean", "--threads", "1", "--json", "-"]
            return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)["hausdorff"]

        ours, (lower, upper) = seconds(resource.RUSAGE_CHILDREN, by_proxima)
        theirs, distance = seconds(resource.RUSAGE_SELF, by_vtk)
        print(f"| {a}, {b} | {count_a}, {count_b} | {lower:.9g} to {upper:.9g} | {ours:.2f} | {distance:.9g} | {theirs:.2f} |", flush=True)


if __name__ == "__main__":
    main()
