//! Attributes of groups, read with the library's own codec.
//!
//! `rust-hdf5` 0.7 lists the attributes of a group but hands out only those that are strings. The
//! contract keeps nearly all its numbers in groups, so this walk visits every object once, with the
//! library's decoders of headers, links and attributes, and keeps what it finds by path. It follows
//! hard links only; the library resolves soft links to the path of the object.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use rust_hdf5::format::btree_v1::{BTreeV1Config, BTreeV1Node};
use rust_hdf5::format::dense_attr::read_dense_attributes;
use rust_hdf5::format::dense_link::read_dense_links;
use rust_hdf5::format::local_heap::{LocalHeapHeader, local_heap_get_string};
use rust_hdf5::format::messages::attr_info::AttributeInfoMessage;
use rust_hdf5::format::messages::attribute::AttributeEntry;
use rust_hdf5::format::messages::continuation::ContinuationMessage;
use rust_hdf5::format::messages::link::{LinkMessage, LinkTarget};
use rust_hdf5::format::messages::link_info::LinkInfoMessage;
use rust_hdf5::format::messages::{
    MSG_ATTR_INFO, MSG_ATTRIBUTE, MSG_FLAG_SHARED, MSG_LINK, MSG_LINK_INFO, MSG_OBJ_HEADER_CONTINUATION,
    MSG_SYMBOL_TABLE,
};
use rust_hdf5::format::object_header::{ObjectHeader, ObjectHeaderMessage};
use rust_hdf5::format::superblock::{SuperblockV0V1, SuperblockV2V3};
use rust_hdf5::format::symbol_table::SymbolTableNode;
use rust_hdf5::format::{BlockReader, FormatContext, FormatError, FormatResult};

/// Attributes by the path of their object (no leading `/`; the root is the empty path).
pub(super) type AttributeTable = BTreeMap<String, Vec<AttributeEntry>>;

/// Bytes read at first for an object header; one that is longer says by how much.
const HEADER_PROBE: usize = 2048;
/// Bounds that only a damaged or hostile file reaches.
const MAX_DEPTH: usize = 32;
const MAX_OBJECTS: usize = 100_000;
const MAX_BLOCKS: usize = 4096;

/// Reads the attributes of every object of the file whose superblock stands at `superblock`.
pub(super) fn read_attributes(file: File, superblock: u64) -> FormatResult<AttributeTable> {
    let length = file.metadata().map_err(damaged)?.len();
    let mut blocks = Blocks { file, base: superblock, length };
    let head = blocks.read_block(0, 256)?;
    let (context, config, root) = match head.get(8) {
        Some(0 | 1) => {
            let block = SuperblockV0V1::decode(&head)?;
            let config = BTreeV1Config {
                sym_leaf_k: block.sym_leaf_k,
                snode_internal_k: block.btree_internal_k,
                ..BTreeV1Config::default()
            };
            let context =
                FormatContext { sizeof_addr: block.sizeof_offsets, sizeof_size: block.sizeof_lengths };
            (context, config, block.root_symbol_table_entry.obj_header_addr)
        }
        _ => {
            let block = SuperblockV2V3::decode(&head)?;
            let context =
                FormatContext { sizeof_addr: block.sizeof_offsets, sizeof_size: block.sizeof_lengths };
            (context, BTreeV1Config::default(), block.root_group_object_header_address)
        }
    };
    let mut walk = Walk { blocks, context, config, table: AttributeTable::new(), trail: Vec::new() };
    walk.visit(String::new(), root)?;
    Ok(walk.table)
}

fn damaged(error: impl std::fmt::Display) -> FormatError {
    FormatError::InvalidData(error.to_string())
}

/// The bytes of the file, measured from its superblock.
struct Blocks {
    file: File,
    base: u64,
    length: u64,
}

impl BlockReader for Blocks {
    fn read_block(&mut self, offset: u64, len: usize) -> FormatResult<Vec<u8>> {
        let start = self.base.checked_add(offset).filter(|&at| at < self.length);
        let start =
            start.ok_or_else(|| damaged(format!("address {offset:#x} lies beyond the end of the file")))?;
        self.file.seek(SeekFrom::Start(start)).map_err(damaged)?;
        let mut bytes = Vec::new();
        (&mut self.file).take(len as u64).read_to_end(&mut bytes).map_err(damaged)?;
        Ok(bytes)
    }
}

struct Walk {
    blocks: Blocks,
    context: FormatContext,
    config: BTreeV1Config,
    table: AttributeTable,
    /// Addresses from the root to the object in hand: a hard link back to one of them is a loop.
    trail: Vec<u64>,
}

impl Walk {
    fn visit(&mut self, path: String, address: u64) -> FormatResult<()> {
        if self.trail.len() > MAX_DEPTH || self.table.len() > MAX_OBJECTS || self.trail.contains(&address) {
            return Ok(());
        }
        let messages = self.messages(address)?;
        let attributes = self.attributes(&messages)?;
        self.table.insert(path.clone(), attributes);
        self.trail.push(address);
        for (name, target) in self.links(&messages)? {
            let child = if path.is_empty() { name } else { format!("{path}/{name}") };
            self.visit(child, target)?;
        }
        self.trail.pop();
        Ok(())
    }

    /// All messages of an object header, its continuation blocks included.
    fn messages(&mut self, address: u64) -> FormatResult<Vec<ObjectHeaderMessage>> {
        let probe = self.blocks.read_block(address, HEADER_PROBE)?;
        let header = match ObjectHeader::decode_any(&probe) {
            Err(FormatError::BufferTooShort { needed, .. }) if needed > HEADER_PROBE => {
                ObjectHeader::decode_any(&self.blocks.read_block(address, needed)?)?.0
            }
            other => other?.0,
        };
        let modern = probe.starts_with(b"OHDR");
        let ordered = header.has_creation_order();
        let mut all = header.messages;
        let mut next = 0;
        let mut blocks = 0;
        while next < all.len() {
            if all[next].msg_type == MSG_OBJ_HEADER_CONTINUATION {
                blocks += 1;
                if blocks > MAX_BLOCKS {
                    return Err(damaged("an object header continues without end"));
                }
                let (at, _) = ContinuationMessage::decode(&all[next].data, &self.context)?;
                let length = usize::try_from(at.length).map_err(damaged)?;
                let block = self.blocks.read_block(at.offset, length)?;
                all.extend(if modern { modern_messages(&block, ordered)? } else { legacy_messages(&block)? });
            }
            next += 1;
        }
        Ok(all)
    }

    fn attributes(&mut self, messages: &[ObjectHeaderMessage]) -> FormatResult<Vec<AttributeEntry>> {
        let mut found = Vec::new();
        for message in messages.iter().filter(|m| m.flags & MSG_FLAG_SHARED == 0) {
            if message.msg_type == MSG_ATTRIBUTE {
                found.push(AttributeEntry::parse(&message.data, &self.context)?);
            } else if message.msg_type == MSG_ATTR_INFO {
                let (information, _) = AttributeInfoMessage::decode(&message.data, &self.context)?;
                if information.is_dense() {
                    found.extend(read_dense_attributes(&information, &self.context, &mut self.blocks)?);
                }
            }
        }
        Ok(found)
    }

    /// Names and addresses of the hard links of an object; a dataset has none.
    fn links(&mut self, messages: &[ObjectHeaderMessage]) -> FormatResult<Vec<(String, u64)>> {
        let mut links = Vec::new();
        for message in messages {
            match message.msg_type {
                MSG_LINK => links.push(LinkMessage::decode(&message.data, &self.context)?.0),
                MSG_LINK_INFO => {
                    let (information, _) = LinkInfoMessage::decode(&message.data, &self.context)?;
                    if information.is_dense() {
                        links.extend(read_dense_links(&information, &self.context, &mut self.blocks)?);
                    }
                }
                MSG_SYMBOL_TABLE => return self.symbol_table(&message.data),
                _ => {}
            }
        }
        let hard = |link: LinkMessage| match link.target {
            LinkTarget::Hard { address } => Some((link.name, address)),
            _ => None,
        };
        Ok(links.into_iter().filter_map(hard).collect())
    }

    /// Links of a group of the old kind: a tree of nodes of entries, their names in a heap.
    fn symbol_table(&mut self, message: &[u8]) -> FormatResult<Vec<(String, u64)>> {
        let (width, size) = (usize::from(self.context.sizeof_addr), usize::from(self.context.sizeof_size));
        let (tree, heap) = (little_endian(message, 0, width)?, little_endian(message, width, width)?);
        let header = LocalHeapHeader::decode(&self.blocks.read_block(heap, 64)?, width, size)?;
        let length = usize::try_from(header.data_size).map_err(damaged)?;
        let names = self.blocks.read_block(header.data_addr, length)?;
        let node_size = self.config.symbol_table_node_size(width, size);
        let capacity = self.config.sym_leaf_max_entries();
        let mut links = Vec::new();
        for leaf in self.leaves(tree)? {
            let node =
                SymbolTableNode::decode(&self.blocks.read_block(leaf, node_size)?, width, size, capacity)?;
            for entry in node.entries {
                if matches!(entry.cache, rust_hdf5::format::superblock::SymbolTableCache::SoftLink { .. }) {
                    continue;
                }
                links.push((local_heap_get_string(&names, entry.name_offset)?, entry.obj_header_addr));
            }
        }
        Ok(links)
    }

    /// Addresses of the leaves of a group's tree.
    fn leaves(&mut self, root: u64) -> FormatResult<Vec<u64>> {
        let (width, size) = (usize::from(self.context.sizeof_addr), usize::from(self.context.sizeof_size));
        let node_size = self.config.snode_btree_node_size(width, size);
        let (mut leaves, mut pending, mut visited) = (Vec::new(), vec![root], 0);
        while let Some(address) = pending.pop() {
            visited += 1;
            if visited > MAX_BLOCKS {
                return Err(damaged("the tree of a group has no end"));
            }
            let block = self.blocks.read_block(address, node_size)?;
            let node = BTreeV1Node::decode(&block, width, size, self.config.snode_max_entries())?;
            if node.level == 0 { leaves.extend(node.children) } else { pending.extend(node.children) }
        }
        Ok(leaves)
    }
}

fn little_endian(bytes: &[u8], start: usize, width: usize) -> FormatResult<u64> {
    let slice = bytes.get(start..start + width).filter(|slice| slice.len() <= 8);
    let slice = slice.ok_or_else(|| damaged("an address is cut short"))?;
    Ok(slice.iter().rev().fold(0, |value, &byte| (value << 8) | u64::from(byte)))
}

/// Messages of a continuation block of a version-1 header: bare messages, decoded behind a header of their own.
fn legacy_messages(block: &[u8]) -> FormatResult<Vec<ObjectHeaderMessage>> {
    let length = u32::try_from(block.len()).map_err(damaged)?;
    let mut header = vec![1, 0, 0xff, 0xff, 1, 0, 0, 0];
    header.extend_from_slice(&length.to_le_bytes());
    header.extend_from_slice(&[0; 4]);
    header.extend_from_slice(block);
    Ok(ObjectHeader::decode_v1(&header)?.0.messages)
}

/// Messages of a continuation block of a version-2 header: `OCHK`, messages, checksum.
fn modern_messages(block: &[u8], ordered: bool) -> FormatResult<Vec<ObjectHeaderMessage>> {
    let body = block.strip_prefix(b"OCHK").and_then(|rest| rest.len().checked_sub(4).map(|end| &rest[..end]));
    let mut rest = body.ok_or_else(|| damaged("a continuation block of an object header is damaged"))?;
    let envelope = if ordered { 6 } else { 4 };
    let mut messages = Vec::new();
    while rest.len() >= envelope {
        let length = usize::from(u16::from_le_bytes([rest[1], rest[2]]));
        let data = rest.get(envelope..envelope + length);
        let data = data.ok_or_else(|| damaged("a message of an object header is cut short"))?;
        let (msg_type, flags) = (rest[0], rest[3]);
        messages.push(ObjectHeaderMessage { msg_type, flags, creation_index: 0, data: data.to_vec() });
        rest = &rest[envelope + length..];
    }
    Ok(messages)
}
