//! A compute shader over numbers and textures.

use crate::skip::skip;
use half::f16;
use std::future::Future;
use std::pin::pin;
use std::sync::{Mutex, OnceLock};
use std::task::{Context, Poll, Waker};
use wgpu::util::DeviceExt;
use whitefurnace::table::Storage;
use whitefurnace::table::texture::Texture;

/// A GPU, one user at a time.
pub(crate) struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// How far its filter weights are off, at most.
    pub(crate) weight_error: f64,
    busy: Mutex<()>,
}

/// Futures of native wgpu are ready when they are made.
fn ready<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        std::thread::yield_now();
    }
}

/// The adapter, or `None` with a word.
pub(crate) fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Option<Gpu>> = OnceLock::new();
    GPU.get_or_init(|| match Gpu::new() {
        Ok(gpu) => Some(gpu),
        Err(reason) => {
            let required = std::env::var_os("FURNACE_REQUIRE_GPU").is_some_and(|value| value == "1");
            assert!(!required, "no Vulkan adapter: {reason}");
            skip(format!("no Vulkan adapter: {reason}"));
            None
        }
    })
    .as_ref()
}

impl Gpu {
    fn new() -> Result<Self, String> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = ready(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
        let adapter = adapter.map_err(|error| error.to_string())?;
        let wanted = wgpu::Features::FLOAT32_FILTERABLE | wgpu::Features::TEXTURE_FORMAT_16BIT_NORM;
        let description = wgpu::DeviceDescriptor {
            required_features: adapter.features() & wanted,
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = ready(adapter.request_device(&description)).map_err(|error| error.to_string())?;
        let mut gpu = Self {
            device,
            queue,
            weight_error: 0.0,
            busy: Mutex::new(()),
        };
        gpu.weight_error = gpu.measured_weights();
        println!(
            "{}: filter weights off by {:e}",
            adapter.get_info().name,
            gpu.weight_error
        );
        Ok(gpu)
    }

    /// Whether textures of this format can be filtered; says so where they cannot.
    pub(crate) fn filters(&self, storage: Storage) -> bool {
        let needed = match storage {
            Storage::F32 => wgpu::Features::FLOAT32_FILTERABLE,
            Storage::Unorm16 => wgpu::Features::TEXTURE_FORMAT_16BIT_NORM,
            Storage::F16 | Storage::Unorm8 => wgpu::Features::empty(),
        };
        let filters = self.device.features().contains(needed);
        if !filters {
            skip(format!("the adapter does not filter {}", storage.name()));
        }
        filters
    }

    /// The largest difference of a filtered ramp between two texels from a straight line.
    fn measured_weights(&self) -> f64 {
        let bytes: Vec<u8> = [0.0f32, 1.0]
            .iter()
            .flat_map(|value| f16::from_f32(*value).to_le_bytes())
            .collect();
        let texture = self.texture(wgpu::TextureFormat::R16Float, [2, 1, 1], 1, &bytes);
        let count = 10_000;
        let inputs: Vec<f32> = (0..count)
            .map(|i| 0.25 + 0.5 * (i as f32 + 0.3) / count as f32)
            .collect();
        let wgsl =
            "@group(0) @binding(0) var ramp: texture_2d<f32>;\n@group(0) @binding(1) var ramp_sampler: sampler;\n";
        let body = "outputs[i] = textureSampleLevel(ramp, ramp_sampler, vec2f(inputs[i], 0.5), 0.0).r;";
        let found = self.dispatch(wgsl, body, &[(0, &texture)], &inputs, (count, count));
        let exact = inputs.iter().map(|at| 2.0 * f64::from(*at) - 0.5);
        exact
            .zip(found)
            .map(|(exact, found)| (exact - f64::from(found)).abs())
            .fold(0.0, f64::max)
    }

    fn texture(&self, format: wgpu::TextureFormat, size: [usize; 3], axes: usize, bytes: &[u8]) -> wgpu::TextureView {
        let texture = self.device.create_texture_with_data(
            &self.queue,
            &wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d {
                    width: size[0] as u32,
                    height: size[1] as u32,
                    depth_or_array_layers: size[2] as u32,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: if axes == 3 {
                    wgpu::TextureDimension::D3
                } else {
                    wgpu::TextureDimension::D2
                },
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            bytes,
        );
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }

    /// The texels in the format that the texture says; three channels take four.
    fn upload(&self, texture: &Texture) -> wgpu::TextureView {
        use wgpu::TextureFormat as Format;
        let count = texture.channels.len();
        let (format, padded) = match (texture.storage, count) {
            (Storage::F32, 1) => (Format::R32Float, 1),
            (Storage::F32, 2) => (Format::Rg32Float, 2),
            (Storage::F32, _) => (Format::Rgba32Float, 4),
            (Storage::F16, 1) => (Format::R16Float, 1),
            (Storage::F16, 2) => (Format::Rg16Float, 2),
            (Storage::F16, _) => (Format::Rgba16Float, 4),
            (Storage::Unorm16, 1) => (Format::R16Unorm, 1),
            (Storage::Unorm16, 2) => (Format::Rg16Unorm, 2),
            (Storage::Unorm16, _) => (Format::Rgba16Unorm, 4),
            (Storage::Unorm8, _) => unreachable!("not tested"),
        };
        let mut bytes = Vec::new();
        for texel in texture.values.chunks(count) {
            for value in texel.iter().copied().chain(std::iter::repeat(0.0)).take(padded) {
                match texture.storage {
                    Storage::F32 => bytes.extend((value as f32).to_le_bytes()),
                    Storage::F16 => bytes.extend(f16::from_f64(value).to_le_bytes()),
                    _ => bytes.extend(((value * 65535.0).round() as u16).to_le_bytes()),
                }
            }
        }
        self.texture(format, texture.size(), texture.axes.len(), &bytes)
    }

    /// Runs `body` for `i` in `0..count`, which reads `inputs` and writes `outputs`, `results` numbers in all; `textures` with their
    /// indices are those that it uses.
    pub(crate) fn run(
        &self,
        wgsl: &str,
        body: &str,
        textures: &[(usize, &Texture)],
        inputs: &[f32],
        (count, results): (usize, usize),
    ) -> Vec<f32> {
        let views: Vec<(usize, wgpu::TextureView)> = textures
            .iter()
            .map(|(index, texture)| (*index, self.upload(texture)))
            .collect();
        let views: Vec<(usize, &wgpu::TextureView)> = views.iter().map(|(index, view)| (*index, view)).collect();
        self.dispatch(wgsl, body, &views, inputs, (count, results))
    }

    fn dispatch(
        &self,
        wgsl: &str,
        body: &str,
        textures: &[(usize, &wgpu::TextureView)],
        inputs: &[f32],
        (count, results): (usize, usize),
    ) -> Vec<f32> {
        let _busy = self.busy.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let source = format!(
            "{wgsl}\n@group(1) @binding(0) var<storage, read> inputs: array<f32>;\n\
             @group(1) @binding(1) var<storage, read_write> outputs: array<f32>;\n\
             @compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {{\n    let i = id.x;\n    \
             if i >= {count}u {{\n        return;\n    }}\n    {body}\n}}\n"
        );
        let device = &self.device;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let bytes: Vec<u8> = inputs.iter().flat_map(|value| value.to_le_bytes()).collect();
        let given = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: &bytes,
            usage: wgpu::BufferUsages::STORAGE,
        });
        let size = 4 * results as u64;
        let buffer = |usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let made = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let read = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default() // clamp to edge
        });
        let mut entries = Vec::new();
        for (index, view) in textures {
            entries.push(wgpu::BindGroupEntry {
                binding: 2 * *index as u32,
                resource: wgpu::BindingResource::TextureView(view),
            });
            entries.push(wgpu::BindGroupEntry {
                binding: 2 * *index as u32 + 1,
                resource: wgpu::BindingResource::Sampler(&sampler),
            });
        }
        let group = |index, entries: &[wgpu::BindGroupEntry<'_>]| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &pipeline.get_bind_group_layout(index),
                entries,
            })
        };
        let of_textures = (!entries.is_empty()).then(|| group(0, &entries));
        let of_numbers = group(
            1,
            &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: given.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: made.as_entire_binding(),
                },
            ],
        );
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            if let Some(group) = &of_textures {
                pass.set_bind_group(0, group, &[]);
            }
            pass.set_bind_group(1, &of_numbers, &[]);
            pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&made, 0, &read, 0, size);
        self.queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let view = read.get_mapped_range(..).unwrap();
        view.chunks_exact(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
            .collect()
    }
}
