// Reads every .ktx2 file of a directory with ktx-parse and compares with the .expected beside it.
// node ktx2.mjs DIRECTORY PATH-OF-KTX-PARSE
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [directory, module] = process.argv.slice(2);
const { read, KHR_DF_TRANSFER_LINEAR, KHR_DF_MODEL_RGBSDA } = await import(pathToFileURL(module).href);

// numbers of vulkan_core.h
const FORMATS = {
    f32: [100, 103, 109, 109],
    f16: [76, 83, 97, 97],
    unorm16: [70, 77, 91, 91],
    unorm8: [9, 16, 37, 37],
};

function half(bits) {
    const [exponent, fraction] = [(bits >> 10) & 31, bits & 1023];
    const size = exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
    return bits & 0x8000 ? -size : size;
}

function numbers(bytes, storage) {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const [step, number] = {
        f32: [4, (at) => view.getFloat32(at, true)],
        f16: [2, (at) => half(view.getUint16(at, true))],
        unorm16: [2, (at) => view.getUint16(at, true) / 65535],
        unorm8: [1, (at) => view.getUint8(at) / 255],
    }[storage];
    return Array.from({ length: bytes.byteLength / step }, (_, i) => number(i * step));
}

const text = (value) => (typeof value === 'string' ? value : new TextDecoder().decode(value).replace(/\0$/, ''));

let count = 0;
for (const name of readdirSync(directory).filter((name) => name.endsWith('.ktx2'))) {
    const expected = JSON.parse(readFileSync(join(directory, name.replace(/ktx2$/, 'expected'))));
    const file = read(readFileSync(join(directory, name)));
    const [width, height, depth] = expected.size;
    assert.equal(file.vkFormat, FORMATS[expected.storage][expected.channels - 1], name);
    assert.deepEqual(
        [file.pixelWidth, file.pixelHeight, file.pixelDepth, file.layerCount, file.faceCount, file.levelCount],
        [width, height, expected.axes === 3 ? depth : 0, 0, 1, 1],
    );
    assert.equal(file.supercompressionScheme, 0);
    const [descriptor] = file.dataFormatDescriptor;
    assert.equal(descriptor.transferFunction, KHR_DF_TRANSFER_LINEAR);
    assert.equal(descriptor.colorModel, KHR_DF_MODEL_RGBSDA);
    const stored = expected.channels === 3 ? 4 : expected.channels;
    assert.equal(descriptor.samples.length, stored);
    // R, G, B, and alpha, which has the number 15
    assert.deepEqual(descriptor.samples.map((sample) => sample.channelType & 15), [0, 1, 2, 15].slice(0, stored));

    const found = numbers(file.levels[0].levelData, expected.storage);
    const texels = found.length / stored;
    assert.equal(texels, width * height * depth);
    for (let i = 0; i < texels; i++) {
        const texel = expected.values.slice(i * expected.channels, (i + 1) * expected.channels);
        if (stored > expected.channels) texel.push(1);
        assert.deepEqual(found.slice(i * stored, (i + 1) * stored), texel, `${name} texel ${i}`);
    }
    assert.equal(text(file.keyValue['KTXorientation']), expected.axes === 3 ? 'rdi' : 'rd');
    for (const [key, value] of expected.facts) {
        assert.equal(text(file.keyValue[`whitefurnace.${key}`]), value, `${name} ${key}`);
    }
    count += 1;
}
console.log(`${count} textures`);
