// bench.cpp - conquest and its peers on the same meshes, in one run, on one thread. SPDX-License-Identifier: MIT
//
//     bench RESULTS.csv NAME=MESH_FILE...
//
// Each mesh is quantised to 12 bits once; every codec gets the same whole numbers and must give the same mesh back (up
// to order). Times are of the processor, best of several runs; megavertices per second are of the input's vertices.
// Memory while decoding is the most that was allocated at once, output included, input not.
#include "ours.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <stdexcept>

namespace {

constexpr double kEnoughSeconds = 2; // of runs of one kind
constexpr int kMostRuns = 25;

double seconds()
{
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Run> double time_of(Run run)
{
    const double begin = seconds();
    run();
    return seconds() - begin;
}

// The shortest time that `run` took.
template <class Run> double best_time(Run run)
{
    double best = 1e9, sum = 0;
    for (int n = 0; n < kMostRuns && (n == 0 || sum < kEnoughSeconds); ++n) {
        const double taken = time_of(run);
        best = std::min(best, taken);
        sum += taken;
    }
    return best;
}

// -- One codec on one mesh

bool is_ours(const std::string &codec) { return codec.rfind("conquest", 0) == 0; }

struct Row {
    std::string mesh, codec;
    size_t vertices = 0, faces = 0, bytes = 0;
    double encode = 0, decode = 1e9;    // seconds
    size_t memory = 0;                  // while decoding
    bool same = false;                  // the mesh came back
    double first = 0;                   // ours: seconds until 1 % of the vertices are there,
    size_t first_bytes = 0;             // and bytes used until then
    size_t formula = 0, encoder = 0;    // ours: decoder and encoder by the formulas, bytes
};

std::vector<std::unique_ptr<Codec>> make_codecs()
{
    std::vector<std::unique_ptr<Codec>> codecs;
    codecs.push_back(make_draco(10)); // the one that all are compared with
    codecs.push_back(make_ours());
    codecs.push_back(make_draco(7));
    codecs.push_back(make_draco(5));
    codecs.push_back(make_meshopt());
    codecs.push_back(make_openctm());
    return codecs;
}

struct Entry {
    std::unique_ptr<Codec> codec;
    Bytes bytes;
    Row row;
};

// All but the time to decode.
Row measure(Codec &codec, const Mesh &mesh, const Decoded &expected, Bytes &bytes)
{
    Row row{ mesh.name, codec.name(), mesh.vertices(), mesh.faces() };
    row.encode = best_time([&] { bytes = codec.encode(mesh); });
    bytes.shrink_to_fit();
    row.bytes = bytes.size();
    const size_t before = memory_now();
    memory_reset_peak();
    codec.decode(bytes);
    row.memory = memory_peak() - before;
    const Decoded out = codec.inspect();
    row.same = out.vertices == expected.vertices && out.faces == expected.faces && out.sum == expected.sum;
    codec.release();
    if (!is_ours(row.codec)) return row;
    row.formula = decoder_bytes(bytes);
    row.encoder = encoder_bytes(mesh);
    FirstView view{};
    row.first = best_time([&] { view = first_view(bytes, mesh.vertices() / 100, seconds); });
    row.first_bytes = view.bytes;
    return row;
}

// In turns, so that what slows the machine down for some seconds slows all codecs down.
void time_decoding(std::vector<Entry> &entries)
{
    double sum = 0;
    for (int n = 0; n < kMostRuns && (n < 2 || sum < kEnoughSeconds * static_cast<double>(entries.size())); ++n) {
        for (Entry &e : entries) {
            const double taken = time_of([&] { e.codec->decode(e.bytes); });
            e.codec->release();
            e.row.decode = std::min(e.row.decode, taken);
            sum += taken;
        }
    }
}

std::vector<Entry> measure_all(const Mesh &mesh)
{
    const Decoded expected = inspect(mesh);
    std::vector<Entry> entries;
    for (auto &codec : make_codecs()) {
        if (!codec->handles(mesh)) continue;
        Entry e;
        e.row = measure(*codec, mesh, expected, e.bytes);
        e.codec = std::move(codec);
        entries.push_back(std::move(e));
    }
    time_decoding(entries);
    return entries;
}

// -- Output

double per_vertex(size_t n, const Row &row) { return static_cast<double>(n) / static_cast<double>(row.vertices); }
double speed(double seconds, const Row &row) { return static_cast<double>(row.vertices) / seconds / 1e6; }

void print_heading(std::FILE *csv)
{
    std::printf("%-17s %9s %-13s %9s %7s %8s %8s %8s %7s %7s\n", "", "", "", "", "bits/", "encode", "decode", "memory",
                "size/", "speed/");
    std::printf("%-17s %9s %-13s %9s %7s %8s %8s %8s %7s %7s\n", "mesh", "vertices", "codec", "bytes", "vertex", "Mv/s",
                "Mv/s", "B/vertex", "draco", "draco");
    std::fprintf(csv, "mesh,vertices,faces,codec,bytes,bits_per_vertex,encode_seconds,encode_mvertices_per_second,"
                      "decode_seconds,decode_mvertices_per_second,decode_bytes_per_vertex,size_to_draco10,"
                      "decode_speed_to_draco10,first_percent_seconds,first_percent_bytes,"
                      "formula_decode_bytes_per_vertex,formula_encode_bytes_per_vertex,same_mesh\n");
}

void print_row(const Row &r, const Row &draco, std::FILE *csv)
{
    const double size = static_cast<double>(r.bytes) / static_cast<double>(draco.bytes), faster = draco.decode / r.decode;
    std::printf("%-17s %9zu %-13s %9zu %7.2f %8.3f %8.3f %8.1f %7.2f %7.2f%s\n", r.mesh.c_str(), r.vertices,
                r.codec.c_str(), r.bytes, 8 * per_vertex(r.bytes, r), speed(r.encode, r), speed(r.decode, r),
                per_vertex(r.memory, r), size, faster, r.same ? "" : "  ANOTHER MESH");
    std::fprintf(csv, "%s,%zu,%zu,%s,%zu,%.4f,%.6f,%.4f,%.6f,%.4f,", r.mesh.c_str(), r.vertices, r.faces,
                 r.codec.c_str(), r.bytes, 8 * per_vertex(r.bytes, r), r.encode, speed(r.encode, r), r.decode,
                 speed(r.decode, r));
    std::fprintf(csv, "%.2f,%.4f,%.4f,%.6f,%zu,%.2f,%.2f,%d\n", per_vertex(r.memory, r), size, faster, r.first,
                 r.first_bytes, per_vertex(r.formula, r), per_vertex(r.encoder, r), r.same);
    std::fflush(stdout);
    std::fflush(csv);
}

void print_target(const std::string &what, const std::string &mesh, double value, double limit, bool at_least)
{
    const bool met = at_least ? value >= limit : value <= limit;
    std::printf("%-6s %-48s %-17s %9.3f  (%s %g)\n", met ? "met" : "MISSED", what.c_str(), mesh.c_str(), value,
                at_least ? "at least" : "at most", limit);
}

void print_targets(const Row &r, const Row &draco)
{
    print_target("decode speed / Draco level 10", r.mesh, draco.decode / r.decode, 0.5, true);
    print_target("time until 1 % of the vertices / whole, %", r.mesh, 100 * r.first / r.decode, 2, false);
    print_target("encode, Mvertices/s", r.mesh, speed(r.encode, r), r.vertices < 5000000 ? 0.7 : 0.4, true);
    print_target("decoder, bytes per vertex, formula", r.mesh, per_vertex(r.formula, r), 72, false);
    print_target("encoder, bytes per vertex, formula", r.mesh, per_vertex(r.encoder, r), 190, false);
}

// From the smallest mesh of the generator to the largest.
void print_growth(const std::vector<Row> &ours)
{
    const Row *small = nullptr, *large = nullptr;
    for (const Row &r : ours) {
        if (r.mesh.rfind("terrain", 0) != 0) continue;
        if (!small || r.vertices < small->vertices) small = &r;
        if (!large || r.vertices > large->vertices) large = &r;
    }
    if (!small || small == large) return;
    const std::string range = small->mesh + " .. " + large->mesh.substr(8);
    print_target("growth of decode time per vertex", range,
                 speed(small->decode, *small) / speed(large->decode, *large), 2.5, false);
    print_target("growth of encode time per vertex", range,
                 speed(small->encode, *small) / speed(large->encode, *large), 2.5, false);
}

bool run(int argc, char **argv)
{
    std::FILE *csv = std::fopen(argv[1], "w");
    if (!csv) throw std::runtime_error(std::string(argv[1]) + ": cannot write");
    std::vector<Row> ours, draco;
    bool all_same = true;
    print_heading(csv);
    for (int i = 2; i < argc; ++i) {
        const std::string argument = argv[i];
        const size_t equals = argument.find('=');
        const Mesh mesh = load(argument.substr(0, equals), argument.substr(equals + 1));
        for (const Entry &e : measure_all(mesh)) {
            const Row &row = e.row;
            if (row.codec == "draco-10") draco.push_back(row);
            if (row.codec == "conquest") ours.push_back(row);
            all_same = all_same && row.same;
            print_row(row, draco.back(), csv);
        }
    }
    std::fclose(csv);
    std::printf("\nTargets, ratios within this run:\n");
    for (size_t i = 0; i < draco.size(); ++i) print_targets(ours[i], draco[i]);
    print_growth(ours);
    return all_same;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 3) {
        std::fprintf(stderr, "usage: bench RESULTS.csv NAME=MESH_FILE...\n");
        return 2;
    }
    try {
        return run(argc, argv) ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "bench: %s\n", error.what());
        return 1;
    }
}
