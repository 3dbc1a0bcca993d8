//! Raw numbers by what the JSON beside them says.

use super::sample::all;
use serde_json::Value;
use whitefurnace::export::formats::{Format, files};
use whitefurnace::export::sha256_hex;

#[test]
fn the_json_is_enough_to_read_the_numbers() {
    for texture in all() {
        let [(bin, bytes), (_, json)] = files(&texture, Format::Raw).unwrap().try_into().unwrap();
        let about: Value = serde_json::from_slice(&json).unwrap();
        assert_eq!(about["file"], bin.as_str());
        assert_eq!(about["sha256"], sha256_hex(&bytes).as_str());
        assert_eq!(about["bytes"], bytes.len());
        assert_eq!(about["byteOrder"], "little-endian");
        let size = about["size"]
            .as_array()
            .unwrap()
            .iter()
            .map(|size| size.as_u64().unwrap() as usize);
        let count = size.product::<usize>() * about["channels"].as_array().unwrap().len();
        let step = bytes.len() / count;
        let found = bytes
            .chunks(step)
            .map(|number| match about["storage"].as_str().unwrap() {
                "f32" => f64::from(f32::from_le_bytes(number.try_into().unwrap())),
                "f16" => half::f16::from_le_bytes(number.try_into().unwrap()).to_f64(),
                "unorm16" => f64::from(u16::from_le_bytes(number.try_into().unwrap())) / 65535.0,
                _ => f64::from(number[0]) / 255.0,
            });
        assert_eq!(found.collect::<Vec<_>>(), texture.values, "{}", texture.id);
        let range = [0, 1].map(|end| about["range"][end].as_f64().unwrap());
        assert!(range[0] == 0.0 && range[1] == 1.0, "{range:?}");
        for (found, axis) in about["axes"].as_array().unwrap().iter().zip(&texture.axes) {
            assert_eq!(found["parameter"], axis.axis.parameter.as_str());
            assert_eq!(found["mapping"], axis.axis.mapping.name());
            assert_eq!(found["texelRule"], axis.axis.rule.name());
            assert_eq!(found["shader"], axis.shader_expression().as_str());
            assert_eq!(found["flipped"], axis.flipped);
            assert_eq!(
                (found["min"].as_f64(), found["max"].as_f64()),
                (Some(axis.axis.min), Some(axis.axis.max))
            );
        }
        assert_eq!(about["errors"][0]["max"].as_f64(), Some(texture.errors[0].max));
        assert_eq!(about["errors"][0]["probes"].as_u64(), Some(texture.errors[0].probes));
        assert_eq!(about["facts"][1]["name"], "Größe");
    }
}
