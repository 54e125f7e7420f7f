// Fills holes with CGAL's triangulate_refine_and_fair_hole and measures the time of that call.
//
//   cgal_fill FILE.obj CONTINUITY RUNS [--leave VERTEX]... [-o OUT.obj]
//
// CONTINUITY is CGAL's fairing_continuity: 1 or 2. All boundary loops are filled except those
// through a vertex given by --leave (0-based). Each run starts from a fresh copy of the mesh;
// copying, reading and writing are not timed. Prints one JSON object. cpu_ms_min is processor time,
// which is more reliable than ms_min on a busy machine.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
namespace PMP = CGAL::Polygon_mesh_processing;

// Positions and triangles of a plain OBJ file, in file order.
static bool read_obj(const char* path, Mesh& mesh) {
  std::ifstream in(path);
  if (!in) return false;
  std::string line, word;
  while (std::getline(in, line)) {
    std::istringstream tokens(line);
    tokens >> word;
    if (word == "v") {
      double x, y, z;
      tokens >> x >> y >> z;
      mesh.add_vertex(Kernel::Point_3(x, y, z));
    } else if (word == "f") {
      std::vector<Mesh::Vertex_index> corners;
      while (tokens >> word)
        corners.emplace_back(Mesh::Vertex_index(std::stoul(word) - 1));
      if (mesh.add_face(corners) == Mesh::null_face()) return false;
    }
    word.clear();
  }
  return mesh.number_of_faces() > 0;
}

static void write_obj(const std::string& path, const Mesh& mesh) {
  std::ofstream out(path);
  out << std::setprecision(17);
  for (auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    out << "v " << p.x() << ' ' << p.y() << ' ' << p.z() << '\n';
  }
  for (auto f : mesh.faces()) {
    out << 'f';
    for (auto v : vertices_around_face(mesh.halfedge(f), mesh))
      out << ' ' << std::size_t(v) + 1;
    out << '\n';
  }
}

// One halfedge of every boundary loop to fill.
static std::vector<Mesh::Halfedge_index> holes(const Mesh& mesh,
                                               const std::set<std::size_t>& leave) {
  std::vector<Mesh::Halfedge_index> found;
  std::set<Mesh::Halfedge_index> seen;
  for (auto h : mesh.halfedges()) {
    if (!mesh.is_border(h) || seen.count(h)) continue;
    bool left = false;
    for (auto g : halfedges_around_face(h, mesh)) {
      seen.insert(g);
      left |= leave.count(std::size_t(mesh.target(g))) > 0;
    }
    if (!left) found.push_back(h);
  }
  return found;
}

int main(int argc, char** argv) {
  if (argc < 4) {
    std::cerr << "usage: cgal_fill FILE.obj CONTINUITY RUNS [--leave VERTEX]... [-o OUT.obj]\n";
    return 2;
  }
  const int continuity = std::stoi(argv[2]), runs = std::stoi(argv[3]);
  std::set<std::size_t> leave;
  std::string output;
  for (int i = 4; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--leave") leave.insert(std::stoul(argv[i + 1]));
    if (std::string(argv[i]) == "-o") output = argv[i + 1];
  }
  Mesh mesh;
  if (!read_obj(argv[1], mesh)) {
    std::cerr << argv[1] << ": not a manifold OBJ mesh\n";
    return 1;
  }
  std::vector<double> times, cpu_times;
  bool faired = true;
  Mesh filled;
  for (int run = 0; run < runs; ++run) {
    filled = mesh;
    double ms = 0, cpu = 0;
    for (auto h : holes(mesh, leave)) {
      std::vector<Mesh::Face_index> faces;
      std::vector<Mesh::Vertex_index> vertices;
      const auto cpu_start = std::clock();
      const auto start = std::chrono::steady_clock::now();
      const auto result = PMP::triangulate_refine_and_fair_hole(
          filled, h, std::back_inserter(faces), std::back_inserter(vertices),
          PMP::parameters::fairing_continuity(continuity));
      const auto end = std::chrono::steady_clock::now();
      ms += std::chrono::duration<double, std::milli>(end - start).count();
      cpu += 1e3 * double(std::clock() - cpu_start) / CLOCKS_PER_SEC;
      faired &= std::get<0>(result);
    }
    times.push_back(ms);
    cpu_times.push_back(cpu);
  }
  if (!output.empty()) write_obj(output, filled);
  std::sort(times.begin(), times.end());
  std::cout << "{\"file\": \"" << argv[1] << "\", \"continuity\": " << continuity
            << ", \"runs\": " << runs << ", \"ms_min\": " << times.front()
            << ", \"cpu_ms_min\": " << *std::min_element(cpu_times.begin(), cpu_times.end())
            << ", \"ms_median\": " << times[times.size() / 2]
            << ", \"vertices_added\": " << filled.number_of_vertices() - mesh.number_of_vertices()
            << ", \"faces_added\": " << filled.number_of_faces() - mesh.number_of_faces()
            << ", \"faired\": " << (faired ? "true" : "false") << "}\n";
}
