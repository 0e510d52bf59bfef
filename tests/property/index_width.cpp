// Streams do not depend on the width of indices: this build and the other one write the same bytes and read the same
// meshes.
#include "conquest.h"

#include "model.hpp"
#include "other_width.hpp"

namespace {

namespace ow = other_width;

static_assert(sizeof(ow::cq_index) != sizeof(cq_index), "two widths");

// The model as the other build wants it.
class OtherInput {
public:
    ow::cq_input input{};

    explicit OtherInput(const Model &model) {
        const cq_shape &s = model.input.shape;
        for (const Face &f : model.mesh.faces)
            for (uint32_t v : f) indices.push_back(static_cast<ow::cq_index>(v));
        input.shape.num_vertices = s.num_vertices;
        input.shape.num_faces = s.num_faces;
        input.shape.num_channels = s.num_channels;
        input.goal = static_cast<ow::cq_goal>(model.input.goal);
        input.indices = indices.data();
        for (uint32_t k = 0; k < s.num_channels; ++k) {
            std::memcpy(&input.shape.channel[k], &s.channel[k], sizeof s.channel[k]);
            values[k].assign(model.channel(k).begin(), model.channel(k).end());
            input.values[k] = values[k].data();
        }
    }

private:
    std::vector<ow::cq_index> indices;
    std::vector<ow::cq_value> values[CQ_MAX_CHANNELS];
};

// The narrow build takes values of up to 15 bits only.
bool fits_both(const Model &model)
{
    for (uint32_t k = 0; k < model.input.shape.num_channels; ++k)
        if (model.input.shape.channel[k].bits > 15) return false;
    return true;
}

struct OtherStream {
    ow::coded c;
    explicit OtherStream(const OtherInput &other) { ow::code(&c, &other.input); }
    ~OtherStream() { ow::uncode(&c); }
};

struct OtherDecoding {
    ow::decoding d;
    OtherDecoding(const uint8_t *bytes, size_t size) { ow::decoding_begin(&d, bytes, size); }
    ~OtherDecoding() { ow::decoding_free(&d); }
};

template <typename A, typename B>
bool same_picture(const A &a, const B &b)
{
    if (a.mesh.num_vertices != b.mesh.num_vertices || a.mesh.num_faces != b.mesh.num_faces) return false;
    for (uint32_t h = 0; h < 3u * a.mesh.num_faces; ++h)
        if (a.mesh.origin[h] != b.mesh.origin[h] || a.mesh.twin[h] != b.mesh.twin[h]) return false;
    for (uint32_t k = 0; k < a.shape.num_channels; ++k)
        for (uint32_t j = 0; j < num_shown(&a, k); ++j)
            if (a.channel[k][j] != b.channel[k][j]) return false;
    return true;
}

void both_widths_write_the_same_bytes_and_the_same_map()
{
    Model model(*any_recipe(2.0));
    RC_PRE(fits_both(model));
    Stream s(model);
    OtherStream t{OtherInput(model)};
    RC_ASSERT(s.c.result == CQ_OK);
    RC_ASSERT(t.c.result == ow::CQ_OK);
    RC_ASSERT(t.c.size == s.c.size);
    RC_ASSERT(std::equal(t.c.bytes, t.c.bytes + t.c.size, s.c.bytes));
    RC_ASSERT(std::equal(t.c.map, t.c.map + model.mesh.num_vertices, s.c.map));
}

void both_widths_read_the_same_mesh_at_every_prefix()
{
    Model model(*any_recipe(1.0));
    RC_PRE(fits_both(model));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    for (size_t size = 0; size <= s.c.size; size += 1 + s.c.size / 20) {
        Decoding a(s);
        OtherDecoding b(s.c.bytes, s.c.size);
        auto x = static_cast<int>(decoding_run(&a.d, s.c.bytes, size, 7, 3));
        auto y = static_cast<int>(ow::decoding_run(&b.d, s.c.bytes, size, 50, 100));
        RC_ASSERT(x == y);
        RC_ASSERT(same_picture(*a.d.decoder, *b.d.decoder));
    }
}

void both_widths_say_the_same_to_damaged_streams()
{
    Model model(*any_recipe(1.0));
    RC_PRE(fits_both(model));
    Stream s(model);
    RC_ASSERT(s.c.result == CQ_OK);
    size_t header = s.header_size();
    Random random{*rc::gen::arbitrary<uint32_t>()};
    for (int round = 0; round < 10 && s.c.size > header; ++round) {
        std::vector<uint8_t> bytes(s.c.bytes, s.c.bytes + s.c.size);
        for (uint32_t flips = 1 + random.below(3); flips > 0; --flips)
            bytes[header + random.below(s.c.size - header)] ^= static_cast<uint8_t>(1 << random.below(8));
        Decoding a(bytes.data(), bytes.size());
        OtherDecoding b(bytes.data(), bytes.size());
        auto x = static_cast<int>(decoding_run(&a.d, bytes.data(), bytes.size(), bytes.size(), CQ_NO_LIMIT));
        auto y = static_cast<int>(ow::decoding_run(&b.d, bytes.data(), bytes.size(), bytes.size(), CQ_NO_LIMIT));
        RC_ASSERT(x == y);
        RC_ASSERT(same_picture(*a.d.decoder, *b.d.decoder));
    }
}

}  // namespace

int main(int argc, char **argv)
{
    Properties property(argc, argv);
    property("both widths write the same bytes and the same map", both_widths_write_the_same_bytes_and_the_same_map);
    property("both widths read the same mesh at every prefix", both_widths_read_the_same_mesh_at_every_prefix);
    property("both widths say the same to damaged streams", both_widths_say_the_same_to_damaged_streams);
    return property.end();
}
