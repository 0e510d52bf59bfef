/* text.c - words, lines and numbers of text files. SPDX-License-Identifier: MIT */
#include "reader.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- Encodings ----------------------------------------------------------------------------------------------------- */

static int begins_with(const struct reader *r, const char *bytes, size_t count)
{
    return r->size >= count && memcmp(r->data, bytes, count) == 0;
}

enum encoding { ONE_BYTE, UTF16_LE, UTF16_BE, UTF32 };

/* By a byte order mark, or letters with zeros between them. */
static enum encoding find_encoding(const struct reader *r)
{
    const uint8_t *d = r->data;
    if (begins_with(r, "\xff\xfe\0\0", 4) || begins_with(r, "\0\0\xfe\xff", 4))
        return UTF32;
    if (begins_with(r, "\xff\xfe", 2) || (r->size >= 4 && isprint(d[0]) && d[1] == 0 && isprint(d[2]) && d[3] == 0))
        return UTF16_LE;
    if (begins_with(r, "\xfe\xff", 2) || (r->size >= 4 && d[0] == 0 && isprint(d[1]) && d[2] == 0 && isprint(d[3])))
        return UTF16_BE;
    return ONE_BYTE;
}

/* The code point at r->at, of two units if it needs them; '?' for half of one. */
static uint32_t take_utf16(struct reader *r, int big_endian)
{
    uint32_t unit = (uint32_t)load_bytes(r->data + r->at, 2, big_endian), low = 0;
    r->at += 2;
    if (unit < 0xd800 || unit > 0xdfff)
        return unit;
    if (unit <= 0xdbff && r->size - r->at >= 2)
        low = (uint32_t)load_bytes(r->data + r->at, 2, big_endian);
    if (low < 0xdc00 || low > 0xdfff)
        return '?';
    r->at += 2;
    return 0x10000 + ((unit & 0x3ff) << 10 | (low & 0x3ff));
}

/* At most three bytes for two. */
static uint8_t *put_utf8(uint8_t *to, uint32_t code)
{
    int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const uint8_t lead[4] = { 0, 0xc0, 0xe0, 0xf0 };
    *to++ = (uint8_t)(lead[more] | code >> 6 * more);
    while (more-- > 0)
        *to++ = (uint8_t)(0x80 | (code >> 6 * more & 0x3f));
    return to;
}

static int convert_utf16(struct reader *r, int big_endian)
{
    uint8_t *text = r->size < SIZE_MAX / 2 ? malloc(r->size / 2 * 3 + 1) : NULL, *end = text;
    if (text == NULL)
        return fail(r, "out of memory for the text");
    for (r->at = 0; r->size - r->at >= 2;)
        end = put_utf8(end, take_utf16(r, big_endian));
    r->data = r->converted = text;
    r->size = (size_t)(end - text);
    return 1;
}

int begin_text(struct reader *r)
{
    enum encoding encoding = find_encoding(r);
    r->line = 1;
    if (encoding == UTF32)
        return fail(r, "the text is UTF-32; convert it to UTF-8");
    if (encoding != ONE_BYTE && r->converted == NULL && !convert_utf16(r, encoding == UTF16_BE))
        return 0;
    r->at = begins_with(r, "\xef\xbb\xbf", 3) ? 3 : 0;
    return 1;
}

/* -- Words and lines ----------------------------------------------------------------------------------------------- */

static int is_line_end(const struct reader *r, size_t at)
{
    return at == r->size || r->data[at] == '\n' || r->data[at] == '\r';
}

static int at_line_end(const struct reader *r)
{
    return is_line_end(r, r->at);
}

/* Skips \n, \r\n or \r. */
static void skip_line_end(struct reader *r)
{
    if (r->at == r->size)
        return;
    if (r->data[r->at++] == '\r' && !r->lone_cr && r->at < r->size && r->data[r->at] == '\n')
        r->at++;
    r->line++;
}

static int at_continuation(const struct reader *r)
{
    return r->continued && r->at < r->size && r->data[r->at] == '\\' && is_line_end(r, r->at + 1);
}

/* How many bytes a blank has; 0: there is none. 26 is how DOS ends a text; where texts were joined, a byte order mark
 * may be anywhere. */
static size_t at_blank(const struct reader *r)
{
    if (r->at == r->size)
        return 0;
    int c = r->data[r->at];
    if (c == 0xef && r->size - r->at >= 3 && memcmp(r->data + r->at, "\xef\xbb\xbf", 3) == 0)
        return 3;
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == 26 || (c == ',' && r->commas);
}

static void skip_continuation(struct reader *r)
{
    r->at++;
    skip_line_end(r);
}

/* Skips blanks of this line, and a comment, which no backslash continues. */
static void skip_blanks(struct reader *r)
{
    while (at_blank(r) || at_continuation(r))
        if (at_continuation(r))
            skip_continuation(r);
        else
            r->at += at_blank(r);
    if (r->comments && r->at < r->size && r->data[r->at] == '#')
        while (!at_line_end(r))
            r->at++;
}

struct word take_word(struct reader *r)
{
    skip_blanks(r);
    struct word word = { r->data + r->at, 0 };
    while (!at_line_end(r) && !at_blank(r) && !at_continuation(r))
        r->at++;
    word.length = (size_t)(r->data + r->at - word.text);
    return word;
}

void next_line(struct reader *r)
{
    while (take_word(r).length > 0) {}
    skip_line_end(r);
}

int seek_word(struct reader *r)
{
    skip_blanks(r);
    while (at_line_end(r) && r->at < r->size) {
        skip_line_end(r);
        skip_blanks(r);
    }
    return r->at < r->size;
}

struct word take_rest(struct reader *r)
{
    while (at_blank(r))
        r->at += at_blank(r);
    struct word word = { r->data + r->at, 0 };
    while (!at_line_end(r))
        r->at++;
    word.length = (size_t)(r->data + r->at - word.text);
    while (word.length > 0 && (word.text[word.length - 1] == ' ' || word.text[word.length - 1] == '\t'))
        word.length--;
    return word;
}

int word_is(struct word word, const char *text)
{
    return word.length == strlen(text) && memcmp(word.text, text, word.length) == 0;
}

int word_is_in_any_case(struct word word, const char *text)
{
    if (word.length != strlen(text))
        return 0;
    for (size_t i = 0; i < word.length; i++)
        if (tolower(word.text[i]) != tolower((unsigned char)text[i]))
            return 0;
    return 1;
}

int same_word(struct word a, struct word b)
{
    return a.length == b.length && memcmp(a.text, b.text, a.length) == 0;
}

const char *show(char text[WORD_BYTES], struct word word)
{
    size_t length = word.length < WORD_BYTES ? word.length : WORD_BYTES - 1;
    for (size_t i = 0; i < length; i++)
        text[i] = (char)(word.text[i] >= ' ' && word.text[i] < 127 ? word.text[i] : '?');
    if (length < word.length)
        text[length - 1] = '~';
    text[length] = '\0';
    return text;
}

/* -- Numbers ------------------------------------------------------------------------------------------------------- */

/* +-digits * 10^exponent, without zeros in front. Of more digits than fit, one says whether they are all 0. */
#define MAX_DIGITS 40

struct decimal {
    int negative, num_digits, has_digits, has_more;
    int64_t exponent;
    char digits[MAX_DIGITS];
};

static void add_digit(struct decimal *d, int digit)
{
    d->has_digits = 1;
    if (d->num_digits == 0 && digit == '0')
        return;
    if (d->num_digits < MAX_DIGITS) {
        d->digits[d->num_digits++] = (char)digit;
        return;
    }
    d->has_more |= digit != '0';
    d->exponent++;
}

/* Takes +-digits from word.text[i] on; what counts more than anyone needs stays at that. Returns where they end, or 0. */
static size_t parse_exponent(struct word word, size_t i, int64_t *exponent)
{
    int negative = i < word.length && word.text[i] == '-';
    if (i < word.length && (word.text[i] == '+' || word.text[i] == '-'))
        i++;
    if (i == word.length)
        return 0;
    for (*exponent = 0; i < word.length && isdigit(word.text[i]); i++)
        if (*exponent < 1000000000)
            *exponent = 10 * *exponent + (word.text[i] - '0');
    *exponent = negative ? -*exponent : *exponent;
    return i;
}

static int parse_decimal(struct word word, struct decimal *d)
{
    size_t i = 0;
    int has_point = 0;
    int64_t exponent = 0;
    memset(d, 0, sizeof *d);
    if (word.length > 0 && (word.text[0] == '+' || word.text[0] == '-'))
        d->negative = word.text[i++] == '-';
    for (; i < word.length && (isdigit(word.text[i]) || (word.text[i] == '.' && !has_point)); i++) {
        if (word.text[i] == '.') {
            has_point = 1;
            continue;
        }
        add_digit(d, word.text[i]);
        d->exponent -= has_point;
    }
    if (d->has_digits && i < word.length && (word.text[i] == 'e' || word.text[i] == 'E'))
        i = parse_exponent(word, i + 1, &exponent);
    d->exponent += exponent;
    return d->has_digits && i == word.length;
}

/* Rounds correctly, unless the number is within 10^-40 of the middle of two doubles. */
static double slow_value(const struct decimal *d)
{
    char text[MAX_DIGITS + 32];
    long exponent = d->exponent < -100000 ? -100000 : d->exponent > 100000 ? 100000 : (long)d->exponent;
    snprintf(text, sizeof text, "%.*s%se%ld", d->num_digits, d->digits, d->has_more ? "1" : "",
             exponent - d->has_more);
    return strtod(text, NULL);
}

/* A product or quotient of two numbers that doubles hold is rounded once. Source: Clinger, "How to Read Floating Point
 * Numbers Accurately", 1990. */
static double decimal_value(const struct decimal *d)
{
    static const double power[] = { 1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    uint64_t whole = 0;
    if (d->num_digits == 0)
        return 0;
    if (FLT_EVAL_METHOD != 0 || d->num_digits > 15 || d->exponent < -22 || d->exponent > 22)
        return slow_value(d);
    for (int i = 0; i < d->num_digits; i++)
        whole = 10 * whole + (uint64_t)(d->digits[i] - '0');
    return d->exponent < 0 ? (double)whole / power[-d->exponent] : (double)whole * power[d->exponent];
}

int parse_number(struct word word, double *value, double *unit)
{
    struct decimal d;
    if (!parse_decimal(word, &d))
        return 0;
    double magnitude = decimal_value(&d);
    *value = d.negative ? -magnitude : magnitude;
    *unit = d.exponent == 0 ? 1 : pow(10, (double)d.exponent);
    return 1;
}

int take_number_and_unit(struct reader *r, double *value, double *unit)
{
    char text[WORD_BYTES];
    if (r->free_form)
        seek_word(r);
    struct word word = take_word(r);
    if (parse_number(word, value, unit))
        return 1;
    return word.length == 0 ? fail(r, "number expected, found the end of the line")
                            : fail(r, "number expected, found '%s'", show(text, word));
}

int take_number(struct reader *r, double *value)
{
    double unit;
    return take_number_and_unit(r, value, &unit);
}

int take_position(struct reader *r, struct mesh_file *mesh, size_t vertex)
{
    double value, unit;
    for (size_t i = 0; i < 3; i++)
        if (!take_number_and_unit(r, &value, &unit) || !store_coordinate(r, mesh, 3 * vertex + i, value, unit))
            return 0;
    return 1;
}
