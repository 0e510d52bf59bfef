// All seams of small meshes: every triangulation of the sphere of 4 and 5 vertices and of the disc of up to 5, with every way
// to share the corners at each vertex out among rows, free and clean, that
//
//   - encodes, and decodes step by step through valid meshes, in which corners with one row have one vertex;
//   - moves no row if it is clean;
//   - comes back: all triangles with what their corners have, through the maps.
//
// What was run is counted: the product of the Bell numbers of the valences, twice. With the argument `all`: spheres and
// discs of 6 vertices too, each 97th way.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "../support/records.h"
#include "../support/report.hpp"
#include "comparison.hpp"

namespace {

// The row of each of n corners among those of its vertex, as a restricted growth string: each number is at most one larger
// than all before it.
using Sharing = std::vector<int>;

std::vector<Sharing> all_sharings(int corners)
{
    std::vector<Sharing> all = {{}};
    for (int k = 0; k < corners; ++k) {
        std::vector<Sharing> longer;
        for (const Sharing &s : all) {
            int rows = 0;
            for (int row : s) rows = std::max(rows, row + 1);
            for (int row = 0; row <= rows; ++row) {
                longer.push_back(s);
                longer.back().push_back(row);
            }
        }
        all = longer;
    }
    return all;
}

// A mesh, and the ways to share out the corners at each of its vertices.
class Seams {
public:
    Seams(const Triangulation &t, int num_real) : corners(index_buffer(t, num_real)), place(positions(num_real, 1)) {
        std::vector<int> valence(size_t(num_real), 0);
        for (cq_index v : corners) valence[v]++;
        for (int n : valence) sharings.push_back(all_sharings(n));
        for (const auto &of_vertex : sharings) count *= of_vertex.size();
    }

    size_t ways() const { return count; }

    // Input number `way`: its rows have a position, and coordinates that no other row has.
    cq_input input(size_t way) {
        std::vector<size_t> nth(sharings.size(), 0), first(sharings.size(), 0), chosen(sharings.size());
        uint64_t seed = way + 1;
        position.clear();
        texcoord.clear();
        for (size_t v = 0; v < sharings.size(); ++v, way /= sharings[v - 1].size()) {
            chosen[v] = way % sharings[v].size();
            first[v] = texcoord.size() / 2;
            const Sharing &s = sharings[v][chosen[v]];
            for (int row = 0; row <= *std::max_element(s.begin(), s.end()); ++row) {
                for (size_t c = 0; c < 3; ++c) position.push_back(place[3 * v + c]);
                texcoord.push_back(static_cast<cq_value>(texcoord.size() / 2));
                texcoord.push_back(static_cast<cq_value>(next_random(&seed) % 64));
            }
        }
        index.clear();
        for (cq_index v : corners)
            index.push_back(static_cast<cq_index>(first[v] + size_t(sharings[v][chosen[v]][nth[v]++])));
        return input_of_rows();
    }

private:
    std::vector<cq_index> corners, index;
    std::vector<cq_value> place, position, texcoord;
    std::vector<std::vector<Sharing>> sharings;
    size_t count = 1;

    cq_input input_of_rows() const {
        cq_input in = {};
        in.shape.num_vertices = static_cast<uint32_t>(texcoord.size() / 2);
        in.shape.num_faces = static_cast<uint32_t>(index.size() / 3);
        in.shape.num_channels = 2;
        in.indices = index.data();
        set_channel(in, 0, CQ_POSITION, 3, 10, position);
        set_channel(in, 1, CQ_TEXCOORD, 2, 6, texcoord);
        return in;
    }

    static void set_channel(cq_input &in, int k, cq_kind kind, int components, int bits, const std::vector<cq_value> &values) {
        in.shape.channel[k].kind = static_cast<uint8_t>(kind);
        in.shape.channel[k].components = static_cast<uint8_t>(components);
        in.shape.channel[k].bits = static_cast<uint8_t>(bits);
        in.values[k] = values.data();
    }
};

struct Count {
    size_t streams = 0, splits = 0, moved = 0;
};

// Moved rows of the last step are those that cq_moved_rows tells: none if the stream is clean.
const char *decodes(decoding &d, const coded &coded, bool clean, Count &count)
{
    cq_bytes in = {coded.bytes, coded.size};
    std::vector<cq_index> before;
    cq_index vertices = 0;
    do {
        d.result = cq_decode(d.decoder, &in, 1);
        const cq_decoder &now = *d.decoder;
        if (d.result < 0 || now.mesh.num_vertices == vertices) continue;
        if (cq_mesh_check(&now.mesh, nullptr) != CQ_OK || !rows_are_valid(&now)) return "not valid on the way";
        for (size_t r = 0; now.vertex && r < before.size(); ++r) {
            count.moved += now.vertex[r] != before[r];
            if (clean && now.vertex[r] != before[r]) return "a row moved";
        }
        count.splits += vertices > 0;
        vertices = now.mesh.num_vertices;
        if (now.vertex) before.assign(now.vertex, now.vertex + now.num_rows);
    } while (d.result == CQ_MORE);
    return d.result == CQ_DONE && in.size == 0 ? nullptr : "not complete";
}

const char *round_trip(cq_input &in, Count &count)
{
    coded coded;
    decoding d;
    code(&coded, &in);
    const char *error = coded.result == CQ_OK ? nullptr : "not encoded";
    if (!error) {
        decoding_begin(&d, coded.bytes, coded.size);
        error = decodes(d, coded, in.clean != 0, count);
        if (!error && !(same_triangles(&in, d.decoder) && maps_are_right(&in, d.decoder, coded.map, coded.face_map)))
            error = "does not come back";
        decoding_free(&d);
    }
    uncode(&coded);
    count.streams++;
    return error;
}

void run_mesh(const Triangulation &t, int num_real, size_t step, size_t &expected, Count &count, Report &report)
{
    Seams seams(t, num_real);
    expected += 2 * ((seams.ways() + step - 1) / step);
    for (size_t way = 0; way < seams.ways(); way += step)
        for (int clean = 0; clean < 2; ++clean) {
            cq_input in = seams.input(way);
            in.clean = clean;
            Report::watch();
            if (const char *error = round_trip(in, count)) report.fail(std::string(error) + ": way " + std::to_string(way));
        }
}

size_t run_family(const Family &family, size_t step, Report &report)
{
    Count count;
    size_t expected = 0;
    for (const auto &[code, t] : family.all()) run_mesh(t, t.n - family.is_open(), step, expected, count, report);
    report.expect(expected > 0 && count.streams == expected, "not all were run");
    report.end(family.name() + ": " + std::to_string(count.streams) + " streams, " + std::to_string(count.splits) + " splits, "
               + std::to_string(count.moved) + " rows moved");
    return count.streams;
}

size_t run(Topology topology, int from, int to, size_t step, Report &report)
{
    std::vector<Family> families;
    size_t streams = 0;
    add_families(families, topology, from, to);
    for (const Family &family : families) streams += run_family(family, step, report);
    return streams;
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    size_t streams = run(Topology::sphere, 4, 5, 1, report);
    streams += run(Topology::disc, 3, 5, 1, report);
    std::printf("all seams of spheres of 4 and 5 vertices and discs of up to 5: %zu streams\n", streams);
    if (argc > 1 && std::string(argv[1]) == "all") {
        run(Topology::sphere, 6, 6, 97, report);
        run(Topology::disc, 6, 6, 97, report);
    }
    return report.summary();
}
