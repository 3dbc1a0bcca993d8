//! Tables as other readers see them: the header through `exrheader` of the OpenEXR tools, samples and attributes
//! through the OpenEXR module of Python. Where these are not installed, the tests say so and pass.

mod skip;

use glam::DVec3;
use skip::skip;
use std::path::Path;
use std::process::Command;
use whitefurnace::export::{exr::to_bytes, write::write_whole};
use whitefurnace::spectrum::Channels;
use whitefurnace::table::axis::{Axis, Mapping, TexelRule};
use whitefurnace::table::{Between, ErrorKind, Lobe, Quantity, Table};

fn table(channels: Channels) -> Table {
    let (width, height) = (17, 5);
    let tint = match channels {
        Channels::Grey => DVec3::ONE,
        Channels::Pair => DVec3::new(0.25, 1.0, 1.0),
        Channels::Rgb => DVec3::new(1.0, 0.5, 0.25),
    };
    Table {
        id: "independent".into(),
        quantity: Quantity::RhoHd,
        lobe: Lobe::Reflection,
        axes: vec![
            Axis::new("mu", Mapping::SqrtMu, TexelRule::Centres, [0.0, 1.0], width).unwrap(),
            Axis::new("kappa", Mapping::Log, TexelRule::Ends, [1.0, 4096.0], height).unwrap(),
        ],
        channels,
        values: (0..width * height).map(|i| tint / (1.0 + i as f64 / 3.0)).collect(),
        errors: (0..width * height).map(|i| tint * 1e-9 * i as f64).collect(),
        error_kind: ErrorKind::Bound,
        parameters: vec![("eta".into(), "1.329".into()), ("Größe".into(), "17".into())],
        estimator: "quadrature".into(),
        tolerance: 1e-4 / 3.0,
        evaluations: u64::MAX,
        seed: 7,
        goal: None,
        between: Some(Between {
            error: 2.0 / 3.0,
            at: vec![0.125, 17.0],
            probes: 1000,
        }),
    }
}

/// What `command` prints; `None`, and a note, when it cannot be run.
fn output_of(command: &mut Command) -> Option<String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let Ok(output) = command.output() else {
        skip(format!("{program} is not installed"));
        return None;
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    if program == "python3" && errors.contains("No module named") {
        skip(errors.lines().last().unwrap_or_default());
        return None;
    }
    assert!(output.status.success(), "{program}: {errors}");
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn written(table: &Table, directory: &Path) -> std::path::PathBuf {
    let path = directory.join("table.exr");
    write_whole(&path, &to_bytes(table).unwrap()).unwrap();
    path
}

#[test]
fn exrheader_prints_the_facts() {
    let directory = tempfile::tempdir().unwrap();
    for channels in [Channels::Grey, Channels::Pair, Channels::Rgb] {
        let path = written(&table(channels), directory.path());
        let Some(header) = output_of(Command::new("exrheader").arg(path)) else {
            return;
        };
        let names = match channels {
            Channels::Grey => vec!["Y", "error.Y"],
            Channels::Pair => vec!["R", "G", "error.R", "error.G"],
            Channels::Rgb => vec!["R", "G", "B", "error.R", "error.G", "error.B"],
        };
        for name in names {
            assert!(
                header.contains(&format!("\n    {name}, 32-bit floating-point")),
                "{header}"
            );
        }
        for fact in [
            "quantity (type string): \"rho_hd\"",
            "lobe (type string): \"reflection\"",
            "errorKind (type string): \"bound\"",
            "evaluations (type string): \"18446744073709551615\"",
            "axis0.shader (type string): \"u = sqrt(mu)\"",
            "axis1.shader (type string): \"u = log(kappa/1.0)/log(4096.0)*(4.0/5.0) + 0.5/5.0\"",
            "axis1.texelRule (type string): \"ends\"",
            "eta = 1.329",
            "Größe = 17",
        ] {
            assert!(header.contains(fact), "{fact} is not in\n{header}");
        }
    }
}

/// Prints size, then `name bits...` per channel, then three attributes as bits.
const READER: &str = r#"
import sys, struct
import OpenEXR, numpy
part = OpenEXR.File(sys.argv[1], separate_channels=True).parts[0]
header = part.header
print("size", part.width(), part.height())
for name, channel in sorted(part.channels.items()):
    pixels = numpy.ascontiguousarray(channel.pixels)
    assert pixels.dtype == numpy.float32
    print(name, *pixels.view(numpy.uint32).flatten())
for name in ("tolerance", "betweenError", "maxTexelError"):
    # The module hands doubles out as arrays of one.
    print(name, struct.unpack("<Q", struct.pack("<d", numpy.asarray(header[name], numpy.float64).item()))[0])
"#;

#[test]
fn openexr_reads_every_bit_of_samples_and_numbers() {
    let directory = tempfile::tempdir().unwrap();
    for channels in [Channels::Grey, Channels::Pair, Channels::Rgb] {
        let table = table(channels);
        let path = written(&table, directory.path());
        let Some(output) = output_of(Command::new("python3").arg("-c").arg(READER).arg(path)) else {
            return;
        };
        let texels = 0..table.values.len();
        let line = |name: &str, bits: &mut dyn Iterator<Item = u64>| {
            bits.fold(name.to_string(), |line, bits| format!("{line} {bits}"))
        };
        let sample = |value: f64| u64::from((value as f32).to_bits());
        let mut expected = vec!["size 17 5".to_string()];
        let names: &[(&str, usize)] = match channels {
            Channels::Grey => &[("Y", 0)],
            Channels::Pair => &[("G", 1), ("R", 0)],
            Channels::Rgb => &[("B", 2), ("G", 1), ("R", 0)],
        };
        for &(name, k) in names {
            expected.push(line(name, &mut texels.clone().map(|i| sample(table.values[i][k]))));
            let error = &mut texels.clone().map(|i| sample(table.texel_error(i)[k]));
            expected.push(line(&format!("error.{name}"), error));
        }
        let between = table.between.as_ref().unwrap().error;
        for (name, value) in [
            ("tolerance", table.tolerance),
            ("betweenError", between),
            ("maxTexelError", table.max_texel_error()),
        ] {
            expected.push(line(name, &mut [value.to_bits()].into_iter()));
        }
        for line in &expected {
            assert!(output.lines().any(|found| found == line), "{line}\nis not in\n{output}");
        }
        assert_eq!(output.lines().count(), expected.len());
    }
}
