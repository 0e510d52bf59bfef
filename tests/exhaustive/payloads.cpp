// Every payload of up to 2 bytes behind every valid header of a small shape, and every payload of 3 bytes behind one.
// All check values are right, so that nothing is refused but for what the payload says:
//
//   - the decoder ends, after a bounded number of calls with a budget of one step and of basic blocks executed (where
//     the build counts them; what runs away is stopped);
//   - it ends with CQ_DONE or CQ_ERROR_CORRUPT and says the same when it is called again;
//   - the mesh is valid, after CQ_DONE the one of the header's counts, which is encoded and decoded once more;
//   - one byte less is CQ_TRUNCATED or an error, and the mesh is valid too.
//
// What was run is counted: 1 + 256 + 65536 payloads for each header, and which results came out. With the argument `3`:
// the payloads of 3 bytes.
#define CONQUEST_IMPLEMENTATION
#include "conquest.h"

#include "../support/codec.h"
#include "../support/records.h"
#include "../support/report.hpp"
#include "../support/surface.hpp"

#ifdef COUNT_WORK
namespace {
uint64_t work;   // of one decoding
enum { MOST_WORK = 5000 };
}
extern "C" void __sanitizer_cov_trace_pc(void);
extern "C" __attribute__((no_sanitize("coverage"))) void __sanitizer_cov_trace_pc(void)
{
    if (++work > 1000 * uint64_t(MOST_WORK)) abort();
}
#else
namespace {
uint64_t work;
enum { MOST_WORK = 0 };
}
#endif

namespace {

struct Tally {
    size_t payloads = 0, done = 0, corrupt = 0, truncated = 0, levels = 0;
    uint64_t most_calls = 0, most_work = 0;
};

// -- Shapes ---------------------------------------------------------------------------------------------------------

enum { MOST_VERTICES = 5, MOST_LOOPS = 2, MOST_EDGES = 6, MOST_FACES = 10 };

// Euler's formula with any genus and number of components: F = 2 (V + loops) - edges, give or take multiples of 4.
std::vector<cq_shape> small_shapes()
{
    std::vector<cq_shape> shapes;
    for (uint32_t v = 0; v <= MOST_VERTICES; ++v)
        for (uint32_t loops = 0; loops <= (v > 0 ? MOST_LOOPS : 0); ++loops)
            for (uint32_t edges = 3 * loops; edges <= (loops > 0 ? MOST_EDGES : 0); ++edges)
                for (uint32_t f = 0; f <= (v > 0 ? MOST_FACES : 0); ++f) {
                    cq_shape shape = {};
                    shape.num_vertices = v;
                    shape.num_faces = f;
                    shape.num_boundary_loops = loops;
                    shape.num_boundary_edges = edges;
                    if ((2 * (v + loops) + 4 * MOST_FACES - edges - f) % 4 == 0) shapes.push_back(shape);
                }
    return shapes;
}

cq_shape with_channel(cq_shape shape, cq_kind kind, cq_merge merge, int components, int bits)
{
    cq_channel &c = shape.channel[shape.num_channels++];
    c.kind = static_cast<uint8_t>(kind);
    c.merge = static_cast<uint8_t>(merge);
    c.components = static_cast<uint8_t>(components);
    c.bits = static_cast<uint8_t>(bits);
    return shape;
}

cq_shape with_seams(cq_shape shape, uint32_t more_rows)
{
    shape.num_rows = shape.num_vertices + more_rows;
    return with_channel(shape, CQ_TEXCOORD, CQ_AVERAGE, 2, 1);
}

cq_shape with_materials(cq_shape shape)
{
    shape.num_materials = 2;
    return shape;
}

// A row, a face and a byte beside the mesh.
cq_shape with_aside(cq_shape shape)
{
    shape.num_aside_rows = shape.num_aside_faces = shape.metadata_bytes = 1;
    return with_channel(shape, CQ_GENERIC, CQ_AVERAGE, 1, 1);
}

std::string name(const cq_shape &s)
{
    return std::to_string(s.num_vertices) + " vertices, " + std::to_string(s.num_faces) + " faces, "
         + std::to_string(s.num_boundary_loops) + " loops, " + std::to_string(s.num_boundary_edges) + " edges, "
         + std::to_string(s.num_channels) + " channels, " + std::to_string(s.num_rows) + " rows, "
         + std::to_string(s.num_materials) + " materials";
}

// -- One payload ----------------------------------------------------------------------------------------------------

// Patches and splits of all levels, their ends: each level adds a vertex. One of patches has a patch for three faces at
// most, a regular one passes over its faces a few times.
uint64_t most_calls(const cq_shape &s)
{
    return 2 + uint64_t(s.num_vertices) * (4 * (s.num_faces + s.num_boundary_edges) + 8) + most_calls_for_rows(&s);
}

bool is_final(cq_result result, bool complete)
{
    if (result == CQ_ERROR_CORRUPT) return true;
    return result == (complete ? CQ_DONE : CQ_TRUNCATED);
}

bool is_valid(const cq_decoder &d)
{
    if (d.mesh.num_vertices == 0) return true;
    return cq_mesh_check(&d.mesh, nullptr) == CQ_OK && examine(d.mesh).empty() && rows_are_valid(&d);
}

bool is_complete(const cq_decoder &d)
{
    const uint32_t rows = d.shape.num_rows ? d.shape.num_rows : d.shape.num_vertices;
    return d.mesh.num_vertices == d.shape.num_vertices && d.mesh.num_faces == d.shape.num_faces && d.num_rows == rows
        && d.aside.num_rows == d.shape.num_aside_rows && d.aside.num_faces == d.shape.num_aside_faces
        && d.metadata_read == d.shape.metadata_bytes && materials_are_valid(&d);
}

// The decoded mesh as input: a second stream of it decodes to a mesh of the same counts. With seams that need not be:
// rows of equal values become one.
bool codes_again(const cq_decoder &d)
{
    cq_input in = {};
    in.shape = d.shape;
    in.indices = d.mesh.origin;
    for (uint32_t k = 0; k < d.shape.num_channels; ++k) in.values[k] = d.channel[k];
    coded coded;
    code(&coded, &in);
    decoding again;
    bool same = coded.result == CQ_OK;
    if (same) {
        decoding_begin(&again, coded.bytes, coded.size);
        same = decoding_run(&again, coded.bytes, coded.size, coded.size, CQ_NO_LIMIT) == CQ_DONE
            && examine(faces_of(again.decoder->mesh)) == examine(faces_of(d.mesh));
        decoding_free(&again);
    }
    uncode(&coded);
    return same;
}

class Payloads {
public:
    Payloads(const cq_shape &s, Tally &t, Report &r) : shape(s), tally(t), report(r) {
        memory_size = cq_decoder_bytes(&shape);
        memory = exact_alloc(memory_size);
        decoder = static_cast<cq_decoder *>(exact_alloc(sizeof(cq_decoder)));
    }
    Payloads(const Payloads &) = delete;
    Payloads &operator=(const Payloads &) = delete;
    ~Payloads() {
        exact_free(decoder);
        exact_free(memory);
    }

    // All of `size` bytes.
    void all(size_t size) {
        for (uint32_t bytes = 0; bytes < uint32_t(1) << (8 * size); ++bytes) {
            uint8_t payload[4] = {uint8_t(bytes), uint8_t(bytes >> 8), uint8_t(bytes >> 16), 0};
            if (bytes % 65536 == 0) Report::watch();
            size_t header = write_stream(payload, size);
            if (const char *error = decode(header + size, true)) fail(error, bytes, size);
            tally.payloads++;
            if (size == 0 || payload[size - 1] != 0) continue;   // the byte that is missing plays no part
            if (const char *error = decode(header + size - 1, false)) fail(error, bytes, size - 1);
        }
    }

private:
    cq_shape shape;
    Tally &tally;
    Report &report;
    void *memory;
    size_t memory_size;
    cq_decoder *decoder;
    uint8_t stream[CQ_MAX_HEADER_BYTES + 4];

    void fail(const char *error, uint32_t bytes, size_t size) {
        report.fail(name(shape) + ": " + error + ": payload " + std::to_string(bytes) + " of " + std::to_string(size)
                    + " bytes");
    }

    size_t write_stream(const uint8_t *payload, size_t size) {
        size_t header = cqi_write_header(stream, &shape, size, cqi_crc32(0, payload, size));
        memcpy(stream + header, payload, size);
        return header;
    }

    const char *decode(size_t stream_size, bool complete) {
        uint64_t calls = 0;
        work = 0;
        cq_bytes in = {stream, stream_size};
        cq_decoder_init(decoder, memory, memory_size);
        cq_result result;
        do {
            result = cq_decode(decoder, &in, 1);
            calls++;
        } while (result == CQ_MORE && calls < most_calls(shape));
        if (result == CQ_NEED_INPUT) result = cq_decode(decoder, nullptr, CQ_NO_LIMIT);
        tally.most_work = std::max(tally.most_work, work);
        tally.most_calls = std::max(tally.most_calls, calls);
        return check(result, in, complete);
    }

    const char *check(cq_result result, const cq_bytes &in, bool complete) {
        cq_bytes rest = in;
        count(result);
        if (!is_final(result, complete)) return "another result";
        if (cq_decode(decoder, &rest, 1) != result || rest.size != in.size) return "not permanent";
        if (tally.most_work > MOST_WORK) return "too much work";
        if (!is_valid(*decoder)) return "not valid";
        if (result != CQ_DONE) return nullptr;
        tally.levels += decoder->level;
        if (!is_complete(*decoder)) return "done, but other counts";
        return cqi_is_extended(&shape) || codes_again(*decoder) ? nullptr : "does not come back";
    }

    void count(cq_result result) {
        tally.done += result == CQ_DONE;
        tally.corrupt += result == CQ_ERROR_CORRUPT;
        tally.truncated += result == CQ_TRUNCATED;
    }
};

// -- All of them ----------------------------------------------------------------------------------------------------

void end(const std::string &what, size_t expected, const Tally &t, Report &report)
{
    report.expect(expected > 0 && t.payloads == expected, std::to_string(t.payloads) + " payloads");
    report.expect(t.done > 0 && t.corrupt > 0 && t.truncated > 0, "a result did not occur");
    report.end(what + ": " + std::to_string(t.payloads) + " payloads, " + std::to_string(t.done) + " meshes, "
               + std::to_string(t.levels) + " levels, " + std::to_string(t.corrupt) + " corrupt, "
               + std::to_string(t.truncated) + " cut; at most " + std::to_string(t.most_calls) + " calls, " + std::to_string(t.most_work) + " blocks");
}

bool is_valid_header(const cq_shape &shape)
{
    uint8_t header[CQ_MAX_HEADER_BYTES];
    size_t size = cqi_write_header(header, &shape, 0, 0), header_size = 0, stream_size = 0;
    cq_shape seen;
    return cq_peek(header, size, &seen, &header_size, &stream_size) == CQ_OK && header_size == size
        && stream_size == size && seen.num_vertices == shape.num_vertices && seen.num_faces == shape.num_faces;
}

size_t up_to_two_bytes(const char *what, const std::vector<cq_shape> &shapes, Report &report)
{
    Tally tally;
    size_t expected = 0;
    for (const cq_shape &shape : shapes) {
        report.expect(is_valid_header(shape), name(shape) + ": not valid");
        Payloads payloads(shape, tally, report);
        for (size_t size = 0; size <= 2; ++size) {
            payloads.all(size);
            expected += size_t(1) << (8 * size);
        }
    }
    report.expect(shapes[0].num_channels > 0 || tally.levels > 0, "no level was begun");
    end(std::to_string(shapes.size()) + " headers" + what, expected, tally, report);
    return shapes.size();
}

void three_bytes(Report &report)
{
    cq_shape shape = {};
    shape.num_vertices = 5;
    shape.num_faces = 6;
    Tally tally;
    Payloads(shape, tally, report).all(3);
    report.expect(tally.levels > 0, "no level was begun");
    end(name(shape), size_t(1) << 24, tally, report);
}

}  // namespace

int main(int argc, char **argv)
{
    Report report;
    if (argc > 1 && std::string(argv[1]) == "3") {
        three_bytes(report);
        return report.summary();
    }
    std::vector<cq_shape> bare = small_shapes(), located, valued, exact, copied, grouped, seamed, aside, materials;
    for (const cq_shape &s : bare) {
        grouped.push_back(with_channel(s, CQ_GROUP, CQ_PER_FACE, 1, 1));
        if (s.num_boundary_loops > 0) continue;
        located.push_back(with_channel(s, CQ_POSITION, CQ_AVERAGE, 3, 1));
        valued.push_back(with_channel(s, CQ_GENERIC, CQ_AVERAGE, 1, 1));
        exact.push_back(with_channel(s, CQ_GENERIC, CQ_AVERAGE, 1, CQ_EXACT_BITS));
        copied.push_back(with_channel(s, CQ_GENERIC, CQ_COPY, 1, 1));
        if (s.num_faces == 0) continue;
        for (uint32_t more : {1u, 2u})
            if (s.num_vertices + more <= 3 * s.num_faces) seamed.push_back(with_seams(s, more));
        aside.push_back(with_aside(s));
        materials.push_back(with_materials(s));
    }
    for (auto shapes : {&bare, &located})
        for (cq_shape &s : *shapes) s.regular = 1;
    size_t headers = 0;
    headers += up_to_two_bytes(", regular levels", bare, report);
    headers += up_to_two_bytes(", regular levels, with positions", located, report);
    headers += up_to_two_bytes(" with a value", valued, report);
    headers += up_to_two_bytes(" with an exact value", exact, report);
    headers += up_to_two_bytes(" with a copied value", copied, report);
    headers += up_to_two_bytes(" with a value per face", grouped, report);
    headers += up_to_two_bytes(" with seams", seamed, report);
    headers += up_to_two_bytes(" with a row, a face and a byte aside", aside, report);
    headers += up_to_two_bytes(" with two materials", materials, report);
    std::printf("payloads of up to 2 bytes behind %zu headers\n", headers);
    return report.summary();
}
