// face_collapse.cpp - progressive coding by removing triangles, beside removing edges. SPDX-License-Identifier: MIT
//
//     face_collapse MODELS TORUS FILE ...
//
// MODELS is a folder that has models of the paper's Table 1 as NAME.off, TORUS the file of its torus, FILE any mesh.
// All that are oriented manifolds of triangles are coded in every way and decoded; CGAL examines each decoded level.
// Then rates and distances are printed; README.md says what they mean.
//
// Exit status: 0; 1 if a mesh did not come back, a level is not valid, or nothing was checked; 2 for bad usage.
#include "statistics.hpp"
#include "surface.hpp"

#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>

namespace {

const double EDGE_BOUND = 4.85, FACE_BOUND = 3;      // the paper's, section 3

const Kind kinds[] = {Kind::EDGE, Kind::FACE, Kind::MIXED};
const Choice choices[] = {Choice::SMALLEST, Choice::LARGEST, Choice::SHORTEST, Choice::DISTINCT};
enum { NUM_KINDS = 3, NUM_CHOICES = 4 };

// The ends of an edge are always distinct.
bool is_way(Kind kind, Choice choice) { return kind != Kind::EDGE || choice != Choice::DISTINCT; }
enum { NUM_WAYS = NUM_KINDS * NUM_CHOICES - 1 };
const char *const kind_names[] = {"edge", "face", "mixed"};
const char *const choice_names[] = {"smallest valence", "largest valence", "shortest", "distinct ends"};

// -- Round trips ------------------------------------------------------------------------------------------------------

struct Checks {
    size_t meshes = 0, levels = 0, damaged = 0, passed = 0, failed = 0;

    void note(const std::string &name, const char *error) {
        ++(error == nullptr ? passed : failed);
        if (error != nullptr) std::printf("FAIL  %s: %s\n", name.c_str(), error);
    }
};

// Decodes the stream, and again with a wrong bit in front of the last quarter, which must not go unnoticed. Returns
// nullptr, or what is wrong.
const char *check(Checks &checks, const Mesh &mesh, const Topology &topology, const Encoding &e)
{
    const char *error = nullptr;
    Mesh decoded = decode(e.stream, [&](const Mesh &level) {
        Topology found;
        if (error == nullptr) error = examine(level, found);
        if (error == nullptr && !(found == topology)) error = "another topology";
        checks.levels++;
    });
    if (error == nullptr && !is_same(mesh, decoded, e.input_vertex)) error = "the decoded mesh is another one";
    Stream damaged = e.stream;
    if (error != nullptr || damaged.bytes.size() < 64) return error;
    damaged.bytes[damaged.bytes.size() * 3 / 4] ^= 0x80;
    checks.damaged++;
    return is_same(mesh, decode(damaged, [](const Mesh &) {}), e.input_vertex) ? "damage goes unnoticed" : nullptr;
}

using Results = std::array<std::array<std::unique_ptr<Statistics>, NUM_CHOICES>, NUM_KINDS>;

struct Measured {
    std::string name;
    Model_file model;
    Results results;

    const Statistics &at(Kind kind, Choice choice) const { return *results[size_t(kind)][size_t(choice)]; }
    const Statistics &at(Kind kind) const { return at(kind, Choice::SMALLEST); }
};

void measure(Checks &checks, Measured &m)
{
    const Mesh &mesh = m.model.mesh;
    Topology topology;
    if (const char *error = examine(mesh, topology)) return checks.note(m.name, error);
    checks.meshes++;
    for (Kind kind : kinds)
        for (Choice choice : choices) {
            if (!is_way(kind, choice)) continue;
            std::string name = m.name + ", " + kind_names[size_t(kind)] + ", " + choice_names[size_t(choice)];
            try {
                Simplifier s(mesh, m.model.positions, {kind, choice, Place::MEAN});
                s.simplify();
                Encoding e = encode(s, kind);
                checks.note(name, check(checks, mesh, topology, e));
                m.results[size_t(kind)][size_t(choice)] = std::make_unique<Statistics>(mesh, s, e.stream);
            } catch (const std::exception &) {
                checks.note(name, "refinement does not meet the patches of simplification");
            }
        }
}

// -- Tables -----------------------------------------------------------------------------------------------------------

void print_models(const std::vector<Measured> &models)
{
    std::printf("\nModels of the paper's Table 1, smallest valence afterwards; bits per removed vertex\n\n");
    std::printf("%-10s %-6s %14s %6s %9s %8s %17s %8s %8s %6s %6s %9s\n", "", "", "vertices", "", "isolated", "out of",
                "means of indices", "formula", "order 0:", "", "", "simple");
    std::printf("%-10s %-6s %14s %6s %9s %8s %5s %5s %5s %8s %8s %6s %6s %9s\n", "model", "kind", "to base", "levels",
                "per cent", "reach", "i", "j", "k", "", "indices", "flags", "both", "contexts");
    for (const Measured &m : models)
        for (Kind kind : kinds) {
            const Statistics &s = m.at(kind);
            size_t size = kind == Kind::EDGE ? 1 : 2;
            char counts[32], k[8] = "-", formula[8] = "-";
            std::snprintf(counts, sizeof counts, "%zu -> %zu", s.vertices, s.base_vertices);
            if (size == 2) std::snprintf(k, sizeof k, "%.2f", s.index[1][2].mean());
            if (kind != Kind::MIXED) std::snprintf(formula, sizeof formula, "%.2f", s.formula(size));
            std::printf("%-10s %-6s %14s %6zu %9.1f %8.1f %5.2f %5.2f %5s %8s %8.2f %6.2f %6.2f %9.2f\n",
                        kind == Kind::EDGE ? m.name.c_str() : "", kind_names[size_t(kind)], counts, s.levels,
                        s.isolated(), s.out_of_reach(), s.index[size - 1][0].mean(), s.index[size - 1][1].mean(), k,
                        formula, s.indices(), s.flags(), s.order0(), s.contexts());
        }
    std::printf("\nOut of reach: isolated since no run of neighbours is available; others break the link condition.\n"
                "Of mixed: the means of triangles. Formula: the paper's largest entropy at the means measured.\n");
}

void print_package(const std::vector<Measured> &package)
{
    std::printf("\nOriented manifolds of the package with at least 300 vertices: isolated patches in per cent, bits\n"
                "per removed vertex of order 0 (indices; with flags) and with simple contexts\n\n");
    std::printf("%-32s %8s", "mesh", "vertices");
    for (const char *name : kind_names) std::printf("   %s: %*s", name, 22 - int(std::string(name).size()), "");
    std::printf("\n");
    for (const Measured &m : package) {
        std::printf("%-32s %8zu", m.name.c_str(), m.at(Kind::EDGE).vertices);
        for (Kind kind : kinds) {
            const Statistics &s = m.at(kind);
            std::printf("   %5.1f %5.2f %5.2f %5.2f ", s.isolated(), s.indices(), s.order0(), s.contexts());
        }
        std::printf("\n");
    }
}

using Value = std::function<double(const Statistics &)>;

double mean(const std::vector<Measured> &list, Kind kind, Choice choice, const Value &value)
{
    double sum = 0;
    for (const Measured &m : list) sum += value(m.at(kind, choice));
    return sum / double(list.size());
}

void print_choices(const std::vector<Measured> &list, const char *title)
{
    std::printf("\n%s: means of the columns, for each choice of the run\n\n", title);
    std::printf("%-6s %-17s %7s %9s %9s %13s %8s %6s %6s %9s %9s\n", "kind", "choice", "levels", "left, %", "isolated",
                "sum of means", "indices", "flags", "both", "contexts", "in pairs");
    for (Kind kind : kinds)
        for (Choice choice : choices) {
            if (!is_way(kind, choice)) continue;
            auto column = [&](Value value) { return mean(list, kind, choice, value); };
            size_t size = kind == Kind::EDGE ? 1 : 2;
            std::printf("%-6s %-17s %7.1f %9.1f %9.1f %13.2f %8.2f %6.2f %6.2f %9.2f %9.1f\n",
                        kind_names[size_t(kind)], choice_names[size_t(choice)],
                        column([](const Statistics &s) { return double(s.levels); }), column(&Statistics::left),
                        column(&Statistics::isolated),
                        column([size](const Statistics &s) { return s.sum_of_means(size); }),
                        column(&Statistics::indices), column(&Statistics::flags), column(&Statistics::order0),
                        column(&Statistics::contexts), column(&Statistics::in_pairs));
        }
}

// -- Distance ---------------------------------------------------------------------------------------------------------

struct Sizes_and_distances {
    std::vector<double> log_size, log_distance;       // of the levels, finest first

    // Between two levels, linear in the logarithms; NAN if no level is as coarse.
    double at(double size) const {
        double x = std::log(size);
        for (size_t k = 1; k < log_size.size(); ++k)
            if (log_size[k] <= x && x <= log_size[k - 1]) {
                double t = (x - log_size[k - 1]) / (log_size[k] - log_size[k - 1]);
                return std::exp(log_distance[k - 1] + t * (log_distance[k] - log_distance[k - 1]));
            }
        return NAN;
    }
};

enum { NUM_FRACTIONS = 2 };
const double fractions[NUM_FRACTIONS] = {0.1, 0.01};

// Distances of the levels around each fraction of the vertices.
Sizes_and_distances simplify_and_measure(Distance &distance, const Model_file &model, Strategy strategy)
{
    Sizes_and_distances result;
    Simplifier s(model.mesh, model.positions, strategy);
    double all = double(model.mesh.num_real()), before = all;
    Mesh finer = s.mesh;
    std::vector<Position> finer_positions = s.positions;
    auto note = [&](const Mesh &mesh, const std::vector<Position> &positions) {
        result.log_size.push_back(std::log(double(mesh.num_real())));
        result.log_distance.push_back(std::log(distance.to(mesh, positions)));
    };
    for (bool more = true; more;) {
        more = s.add_level();
        double now = double(s.mesh.num_real());
        if (now == before) continue;
        for (double f : fractions)
            if (now <= f * all && f * all < before) note(finer, finer_positions), note(s.mesh, s.positions);
        finer = s.mesh, finer_positions = s.positions, before = now;
    }
    return result;
}

void print_distance(double distance)
{
    if (std::isnan(distance)) std::printf(" %7s", "-");
    else std::printf(" %7.3f", distance);
}

// For each kind, fraction and model: thousandths of the diagonal, and their geometric mean relative to edges.
void print_distances(const std::vector<Measured> &models)
{
    std::printf("\nDistance from the exact surface, root mean square in thousandths of the diagonal, at a tenth and a\n"
                "hundredth of the vertices; last, the geometric mean relative to edges\n\n%-17s %-5s %-6s", "choice",
                "place", "kind");
    for (const Measured &m : models) std::printf(" %15s", m.name.c_str());
    std::printf(" %15s\n", "to edges");
    std::vector<std::unique_ptr<Distance>> distances;
    for (const Measured &m : models) distances.push_back(std::make_unique<Distance>(m.model.mesh, m.model.positions));
    for (Choice choice : {Choice::SMALLEST, Choice::SHORTEST})
        for (Place place : {Place::MEAN, Place::KEPT}) {
            std::vector<double> edge;
            for (Kind kind : kinds) {
                std::vector<double> values;
                std::printf("%-17s %-5s %-6s", choice_names[size_t(choice)], place == Place::MEAN ? "mean" : "kept",
                            kind_names[size_t(kind)]);
                for (size_t n = 0; n < models.size(); ++n) {
                    const Model_file &model = models[n].model;
                    Sizes_and_distances d = simplify_and_measure(*distances[n], model, {kind, choice, place});
                    for (double f : fractions) values.push_back(1000 * d.at(f * double(model.mesh.num_real())));
                    for (size_t f = NUM_FRACTIONS; f > 0; --f) print_distance(values[values.size() - f]);
                }
                if (kind == Kind::EDGE) edge = values;
                for (size_t f = 0; f < NUM_FRACTIONS; ++f) {
                    double sum = 0, count = 0;
                    for (size_t n = f; n < values.size(); n += NUM_FRACTIONS)
                        if (!std::isnan(values[n] + edge[n])) sum += std::log(values[n] / edge[n]), count++;
                    std::printf(" %7.3f", std::exp(sum / count));
                }
                std::printf("\n");
                std::fflush(stdout);
            }
        }
}

// -- Claims -----------------------------------------------------------------------------------------------------------

// Where all valences are 6, i + j is 2 and k is 3, or 2 if it is counted from 1.
double corrected_bound(double k = 3) { return (2 * largest_entropy(1) + largest_entropy(k)) / 2; }

void print_formula()
{
    std::printf("\nThe paper's formula\n");
    std::printf("  edge, i = j = 3/2                                 %.2f\n", 2 * largest_entropy(1.5));
    std::printf("  face as in the paper, i = j = k = 1               %.2f\n", 3 * largest_entropy(1) / 2);
    std::printf("  face, all valences 6: i + j = 2, k = 3            %.2f\n", corrected_bound());
    std::printf("  the same, ends distinct: k = 2, counted from 1    %.2f\n", corrected_bound(2));
}

// How many of the list are at most `bound`, and smallest and largest.
void print_claim(const char *claim, double bound, const std::vector<Measured> &list, Kind kind, const Value &value)
{
    size_t holds = 0;
    std::vector<double> values;
    for (const Measured &m : list) values.push_back(value(m.at(kind)));
    for (double v : values) holds += v <= bound;
    std::printf("  %-66s %3zu of %3zu, %.2f to %.2f\n", claim, holds, list.size(),
                *std::min_element(values.begin(), values.end()), *std::max_element(values.begin(), values.end()));
}

void print_claims(const std::vector<Measured> &list, const char *title)
{
    std::printf("\n%s: on how many it holds; smallest and largest value\n", title);
    print_claim("edge: mean of i + j at most 3", 3, list, Kind::EDGE,
                [](const Statistics &s) { return s.sum_of_means(1); });
    print_claim("edge: indices at most 4.85", EDGE_BOUND, list, Kind::EDGE, &Statistics::indices);
    print_claim("edge: indices and flags at most 4.85", EDGE_BOUND, list, Kind::EDGE, &Statistics::order0);
    print_claim("edge: with simple contexts at most 4.85", EDGE_BOUND, list, Kind::EDGE, &Statistics::contexts);
    print_claim("face: mean of i + j + k at most 3", 3, list, Kind::FACE,
                [](const Statistics &s) { return s.sum_of_means(2); });
    print_claim("face: indices at most 3", FACE_BOUND, list, Kind::FACE, &Statistics::indices);
    print_claim("face: indices at most 3.62", corrected_bound(), list, Kind::FACE, &Statistics::indices);
    print_claim("face: indices and flags at most 3", FACE_BOUND, list, Kind::FACE, &Statistics::order0);
    print_claim("face: with simple contexts at most 3", FACE_BOUND, list, Kind::FACE, &Statistics::contexts);
    print_claim("edge: isolated patches at most 10 per cent", 10, list, Kind::EDGE, &Statistics::isolated);
    print_claim("face: isolated patches at most 10 per cent", 10, list, Kind::FACE, &Statistics::isolated);
    print_claim("mixed: isolated patches at most 10 per cent", 10, list, Kind::MIXED, &Statistics::isolated);
}

// -- Files ------------------------------------------------------------------------------------------------------------

const char *const model_names[] = {"fandisk", "horse", "mannequin", "torus", "dinosaur", "eight", "feline"};

std::vector<Measured> measure_models(Checks &checks, const std::string &folder, const std::string &torus)
{
    std::vector<Measured> models;
    for (std::string name : model_names) {
        std::string path = name == "torus" ? torus : folder + "/" + name + ".off";
        Measured m;
        m.name = name;
        if (!std::ifstream(path)) std::printf("Not in %s: %s\n", folder.c_str(), name.c_str());
        else if (const char *error = read_file(m.model, path)) checks.note(path, error);
        else {
            measure(checks, m);
            models.push_back(std::move(m));
        }
    }
    return models;
}

// The larger ones.
std::vector<Measured> measure_package(Checks &checks, char **paths, int count)
{
    std::vector<Measured> package;
    int refused = 0;
    for (int k = 0; k < count; ++k) {
        Measured m;
        m.name = std::string(paths[k]).substr(std::string(paths[k]).rfind('/') + 1);
        if (read_file(m.model, paths[k]) != nullptr) {
            refused++;
            continue;
        }
        measure(checks, m);
        if (m.model.mesh.num_real() >= 300) package.push_back(std::move(m));
    }
    std::printf("%d files, of which %d are oriented manifolds of triangles\n", count, count - refused);
    return package;
}

}  // namespace

int main(int argc, char **argv)
{
    if (argc < 4) {
        std::fprintf(stderr, "usage: face_collapse MODELS TORUS FILE ...\n");
        return 2;
    }
    Checks checks;
    std::vector<Measured> models = measure_models(checks, argv[1], argv[2]);
    std::vector<Measured> package = measure_package(checks, argv + 3, argc - 3);
    if (!models.empty() && !package.empty() && checks.failed == 0) {
        print_models(models);
        print_choices(models, "Models of Table 1");
        print_package(package);
        print_choices(package, "Package");
        print_formula();
        print_claims(models, "Models of Table 1");
        print_claims(package, "Package");
        print_distances(models);
    }
    if (models.empty() || package.empty()) checks.note("files", "no meshes to measure");
    std::printf("\n%zu meshes in %d ways each: %zu levels examined by CGAL, %zu damaged streams noticed\n",
                checks.meshes, NUM_WAYS, checks.levels, checks.damaged);
    std::printf("%zu passed, %zu failed\n", checks.passed, checks.failed);
    return checks.failed != 0;
}
