// GEOGRAM's cells and meshes on a surface, in C, for tools/bench/surfaces.py. One thread.
#include <geogram/basic/command_line.h>
#include <geogram/basic/command_line_args.h>
#include <geogram/basic/common.h>
#include <geogram/basic/logger.h>
#include <geogram/basic/process.h>
#include <geogram/delaunay/delaunay.h>
#include <geogram/mesh/mesh.h>
#include <geogram/mesh/mesh_remesh.h>
#include <geogram/voronoi/RVD.h>
#include <geogram/voronoi/RVD_callback.h>
#include <geogram/voronoi/generic_RVD.h>

#include <algorithm>
#include <ctime>
#include <vector>

namespace {

void begin() {
    static bool begun = false;
    if (begun) return;
    begun = true;
    GEO::initialize(GEO::GEOGRAM_INSTALL_NONE);
    GEO::CmdLine::import_arg_group("standard");
    GEO::CmdLine::import_arg_group("algo");
    GEO::CmdLine::import_arg_group("remesh");
    GEO::CmdLine::import_arg_group("opt");
    GEO::Logger::instance()->set_quiet(true);
    GEO::Process::enable_multithreading(false);
}

void fill(GEO::Mesh& mesh, const double* vertices, int vertex_count, const int* triangles, int triangle_count) {
    mesh.vertices.set_dimension(3);
    mesh.vertices.create_vertices(GEO::index_t(vertex_count));
    for (int v = 0; v < vertex_count; ++v)
        for (int k = 0; k < 3; ++k) mesh.vertices.point_ptr(GEO::index_t(v))[k] = vertices[3 * v + k];
    for (int t = 0; t < triangle_count; ++t)
        mesh.facets.create_triangle(GEO::index_t(triangles[3 * t]), GEO::index_t(triangles[3 * t + 1]),
                                    GEO::index_t(triangles[3 * t + 2]));
    mesh.facets.connect();
}

class Areas : public GEO::RVDPolygonCallback {
public:
    explicit Areas(double* areas) : areas_(areas) {}
    void operator()(GEO::index_t v, GEO::index_t, const GEOGen::Polygon& polygon) const override {
        if (polygon.nb_vertices() < 3) return;
        const GEO::vec3 a(polygon.vertex(0).point());
        for (GEO::index_t i = 1; i + 1 < polygon.nb_vertices(); ++i)
            areas_[v] += 0.5 * GEO::length(GEO::cross(GEO::vec3(polygon.vertex(i).point()) - a,
                                                      GEO::vec3(polygon.vertex(i + 1).point()) - a));
    }

private:
    double* areas_;
};

double seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

std::vector<double> made_vertices;
std::vector<int> made_triangles;

}  // namespace

// Returns the seconds of the CPU for the cells of `count` points, with signs in double. what: 1 for areas, summed in a
// callback of the polygons; 2 for areas and centroids; 3 for a mesh of the polygons; 4 for that mesh and the dual of
// connected parts, which cuts the surface a second time.
extern "C" double geogram_cells(const double* points, int count, const double* vertices, int vertex_count,
                                const int* triangles, int triangle_count, int what, double* areas) {
    begin();
    GEO::Mesh mesh, made;
    fill(mesh, vertices, vertex_count, triangles, triangle_count);
    std::vector<double> centroids(3 * std::size_t(count));
    GEO::vector<GEO::index_t> dual;
    GEO::vector<double> places;
    const double began = seconds();
    GEO::Delaunay_var delaunay = GEO::Delaunay::create(3, "NN");
    GEO::RestrictedVoronoiDiagram_var cells = GEO::RestrictedVoronoiDiagram::create(delaunay, &mesh);
    cells->set_volumetric(false);
    delaunay->set_vertices(GEO::index_t(count), points);
    Areas callback(areas);
    if (what == 1) cells->for_each_polygon(callback, false, false, false);
    if (what == 2) cells->compute_centroids_on_surface(centroids.data(), areas);
    if (what >= 3) cells->compute_RVD(made, 0, false, false);
    if (what == 4)
        cells->compute_RDT(dual, places,
                           GEO::RestrictedVoronoiDiagram::RDTMode(GEO::RestrictedVoronoiDiagram::RDT_MULTINERVE |
                                                                  GEO::RestrictedVoronoiDiagram::RDT_RVC_CENTROIDS |
                                                                  GEO::RestrictedVoronoiDiagram::RDT_PREFER_SEEDS));
    return seconds() - began;
}

// Makes a mesh of `count` vertices, which geogram_take() copies. Returns the seconds of the CPU.
extern "C" double geogram_remesh(int count, const double* vertices, int vertex_count, const int* triangles,
                                 int triangle_count, int* out_vertices, int* out_triangles) {
    begin();
    GEO::Mesh mesh, made;
    fill(mesh, vertices, vertex_count, triangles, triangle_count);
    const double began = seconds();
    GEO::remesh_smooth(mesh, made, GEO::index_t(count), 3);
    const double took = seconds() - began;
    made_vertices.clear();
    made_triangles.clear();
    for (const GEO::index_t v : made.vertices)
        for (int k = 0; k < 3; ++k) made_vertices.push_back(made.vertices.point_ptr(v)[k]);
    for (const GEO::index_t f : made.facets)
        for (GEO::index_t k = 0; k < 3; ++k) made_triangles.push_back(int(made.facets.vertex(f, k)));
    *out_vertices = int(made_vertices.size() / 3);
    *out_triangles = int(made_triangles.size() / 3);
    return took;
}

extern "C" void geogram_take(double* vertices, int* triangles) {
    std::copy(made_vertices.begin(), made_vertices.end(), vertices);
    std::copy(made_triangles.begin(), made_triangles.end(), triangles);
}
